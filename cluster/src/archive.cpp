#include <fmt/format.h>

#include <cylpose/cluster/archive.hpp>
#include <cylpose/error.hpp>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <thread>

#include "job_store.hpp"

namespace cylpose::cluster {
namespace {

using Json = nlohmann::json;
using std::chrono::milliseconds;

std::string manifest_of(const Archive& archive, std::int64_t jobs) {
  return Json{{"camera", archive.camera_yaml},
              {"parts", archive.parts_yaml},
              {"format", static_cast<int>(archive.format)},
              {"fps", archive.fps},
              {"frames", archive.files.size()},
              {"jobs", jobs}}
      .dump();
}

bool is_name(const std::string& name) {
  constexpr std::string_view kPlain = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789-_";
  return !name.empty() && name.size() <= 64 && name.find_first_not_of(kPlain) == std::string::npos;
}

// Puts images into the server; returns how many messages each takes.
std::vector<int> uploaded(PatientStore& patient, const std::string& words, const std::vector<std::string>& files) {
  std::vector<int> messages;
  for (std::size_t i = 0; i < files.size(); ++i) {
    std::ifstream file(files[i], std::ios::binary);
    std::ostringstream bytes;
    bytes << file.rdbuf();
    if (!file) throw Error(ErrorKind::kInput, files[i] + ": cannot be read");
    patient.ask([&](JobStore& store) { messages.push_back(store.put_frame(words, i, bytes.str())); });
  }
  return messages;
}

}  // namespace

bool Archive::is_valid(std::string* why) const {
  const auto refuse = [why](std::string reason) {
    if (why != nullptr) *why = std::move(reason);
    return false;
  };
  if (!is_name(name)) return refuse("the name is '" + name + "'; use 1 to 64 letters, digits, - and _");
  if (files.empty()) return refuse("it has no frames");
  if (frames_per_job < 1) return refuse(fmt::format("frames_per_job is {}; must be above 0", frames_per_job));
  if (!(fps > 0)) return refuse(fmt::format("fps is {}; must be above 0", fps));
  return true;
}

std::int64_t submit_archive(const ConnectionOptions& options, const Archive& archive) {
  if (std::string why; !archive.is_valid(&why)) throw Error(ErrorKind::kInput, "archive: " + why);
  const Connection connection(options, "cylpose submit");
  connection.await_server();
  constexpr std::chrono::seconds kPatience{30};
  PatientStore patient(connection, kPatience);
  const auto per_job = static_cast<std::size_t>(archive.frames_per_job);
  const auto jobs = static_cast<std::int64_t>((archive.files.size() + per_job - 1) / per_job);
  const std::string manifest = manifest_of(archive, jobs);
  const std::string subject = "cylpose.archive." + archive.name;
  // What comes back is what counts: where the word that it was put is lost, it is put again and refused.
  std::optional<std::string> there;
  patient.ask([&](JobStore& store) {
    store.put_once(subject, manifest);
    there = store.find(subject);
  });
  if (there != manifest) {
    throw Error(ErrorKind::kInput, "another archive is called " + archive.name + " already; choose another name");
  }
  for (std::int64_t number = 0; number < jobs; ++number) {
    const std::size_t first = static_cast<std::size_t>(number) * per_job;
    const std::size_t end = std::min(first + per_job, archive.files.size());
    const std::vector<std::string> files(archive.files.begin() + static_cast<std::ptrdiff_t>(first),
                                         archive.files.begin() + static_cast<std::ptrdiff_t>(end));
    const std::string words = fmt::format("{}.{}", archive.name, number);
    bool done = false;
    patient.ask([&](JobStore& store) { done = store.find("cylpose.poses." + words).has_value(); });
    if (done) continue;
    Json job{{"first", first}, {"files", files}};
    if (archive.upload) job["messages"] = uploaded(patient, words, files);
    const std::string text = job.dump();
    if (const std::size_t most = connection.most_payload(); most > 0 && text.size() + kHeaderBytes > most) {
      throw Error(ErrorKind::kInput,
                  fmt::format("archive {}: a job of {} paths is {} bytes, more than the server takes; "
                              "use fewer --job-frames",
                              archive.name, files.size(), text.size()));
    }
    patient.ask([&](JobStore& store) { store.put_job(words, text); });
  }
  return jobs;
}

std::int64_t collect_archive(const ConnectionOptions& options, const std::string& name,
                             const std::function<void(std::string_view)>& write, const std::function<bool()>& stop) {
  if (!is_name(name)) throw Error(ErrorKind::kInput, "'" + name + "' is no name of an archive");
  const Connection connection(options, "cylpose collect");
  connection.await_server();
  constexpr std::chrono::hours kForEver{24 * 365};
  PatientStore patient(connection, kForEver, stop);
  const auto find = [&](const std::string& subject) {
    std::optional<std::string> found;
    patient.ask([&](JobStore& store) { found = store.find(subject); });
    return found;
  };
  const auto manifest_text = find("cylpose.archive." + name);
  if (!manifest_text && stop()) return 0;
  if (!manifest_text) throw Error(ErrorKind::kInput, "there is no archive " + name + "; `cylpose submit` makes one");
  const Json manifest = Json::parse(*manifest_text);
  const auto jobs = manifest.at("jobs").get<std::int64_t>();
  const bool has_header = static_cast<PoseFormat>(manifest.at("format").get<int>()) == PoseFormat::kCsv;
  for (std::int64_t number = 0; number < jobs; ++number) {
    std::optional<std::string> text;
    while (!(text = find(fmt::format("cylpose.poses.{}.{}", name, number)))) {
      if (stop()) return number;
      constexpr milliseconds kLook{50};
      std::this_thread::sleep_for(kLook);
    }
    const Json result = Json::parse(*text);
    if (result.contains("error")) {
      throw Error(ErrorKind::kInput,
                  fmt::format("archive {}, job {}: {}", name, number, result["error"].get<std::string>()));
    }
    const auto poses = result.at("poses").get<std::string>();
    const std::size_t from = has_header && number > 0 ? poses.find('\n') + 1 : 0;
    write(std::string_view(poses).substr(from));
  }
  // What workers were killed too early to drop.
  patient.ask([&](JobStore& store) { store.drop_frames(name); });
  return jobs;
}

}  // namespace cylpose::cluster
