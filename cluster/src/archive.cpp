#include <fmt/format.h>

#include <cstdlib>
#include <cylpose/cluster/archive.hpp>
#include <cylpose/error.hpp>
#include <cylpose/estimator.hpp>
#include <cylpose/frame_source.hpp>
#include <cylpose/image_cv.hpp>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <thread>

#include "job_store.hpp"

namespace cylpose::cluster {
namespace {

using Json = nlohmann::json;
using std::chrono::milliseconds;

constexpr milliseconds kRetry{250};

std::string manifest_of(const Archive& archive, std::int64_t jobs) {
  return Json{{"camera", archive.camera_yaml},
              {"parts", archive.parts_yaml},
              {"format", static_cast<int>(archive.format)},
              {"fps", archive.fps},
              {"frames", archive.files.size()},
              {"jobs", jobs}}
      .dump();
}

/// A folder for files that the readers and writers of files need; gone with the object.
class Folder {
 public:
  Folder() {
    std::string pattern = (std::filesystem::temp_directory_path() / "cylpose_job_XXXXXX").string();
    if (::mkdtemp(pattern.data()) == nullptr) {
      throw Error(ErrorKind::kOutput, pattern + ": cannot be made; set TMPDIR to a folder with room");
    }
    path_ = pattern;
  }
  ~Folder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;

  [[nodiscard]] std::filesystem::path write(const char* name, const std::string& text) const {
    std::ofstream(path_ / name, std::ios::binary) << text;
    return path_ / name;
  }
  [[nodiscard]] std::filesystem::path file(const char* name) const { return path_ / name; }

 private:
  std::filesystem::path path_;
};

std::string text_of(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

/// Estimators own their backend; this one belongs to the worker.
class Borrowed final : public Backend {
 public:
  explicit Borrowed(Backend& backend) : backend_(backend) {}
  [[nodiscard]] std::string_view name() const override { return backend_.name(); }
  [[nodiscard]] EdgeField detect(const ImageView& image, const Roi& search, std::span<const PartModel> parts,
                                 const DetectOptions& options) override {
    return backend_.detect(image, search, parts, options);
  }

 private:
  Backend& backend_;
};

// The text of a poses file for the frames of one job. Calls `alive` after each.
std::string poses_of(Backend& backend, const Json& manifest, const Json& job, const std::function<void()>& alive) {
  const Folder folder;
  const CameraModel camera = load_camera(folder.write("camera.yaml", manifest.at("camera").get<std::string>()));
  const std::vector<PartModel> parts = load_parts(folder.write("parts.yaml", manifest.at("parts").get<std::string>()));
  const auto estimator = make_estimator(camera, parts, std::make_unique<Borrowed>(backend));
  std::vector<std::string> names;
  names.reserve(parts.size());
  for (const PartModel& part : parts) names.push_back(part.name);
  PoseWriter writer(folder.file("poses"), static_cast<PoseFormat>(manifest.at("format").get<int>()), names);
  const auto first = job.at("first").get<std::int64_t>();
  const auto fps = manifest.at("fps").get<double>();
  const auto files = job.at("files").get<std::vector<std::string>>();
  for (std::size_t i = 0; i < files.size(); ++i) {
    const std::int64_t index = first + static_cast<std::int64_t>(i);
    FrameEstimate estimate;
    std::string error = "there is no such file: " + files[i];
    if (std::filesystem::is_regular_file(files[i])) {
      const std::optional<Frame> frame = open_frames({files[i]})->next();
      error = frame ? frame->error : "no image in " + files[i];
      if (error.empty()) estimate = estimator->estimate(view_of(frame->image));
    }
    if (!error.empty()) {
      PoseEstimate none;
      none.reason = error;
      estimate.parts.assign(parts.size(), none);
    }
    writer.write(index, static_cast<double>(index) / fps, estimate);
    alive();
  }
  writer.close();
  return text_of(folder.file("poses"));
}

bool is_name(const std::string& name) {
  constexpr std::string_view kPlain = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789-_";
  return !name.empty() && name.size() <= 64 && name.find_first_not_of(kPlain) == std::string::npos;
}

class JobWorker {
 public:
  JobWorker(Backend& backend, const Connection& connection, const std::function<void(const std::string&)>& on_event)
      : backend_(backend), connection_(connection), on_event_(on_event) {}

  // A server that fails at any point leaves the job in the queue: it comes again.
  void step() {
    try {
      if (connection_.connected()) return work();
    } catch (const Error& error) {
      if (error.kind() != ErrorKind::kDevice) throw;
      if (on_event_) on_event_(error.what());
      store_.reset();
    }
    std::this_thread::sleep_for(kRetry);
  }

 private:
  void work() {
    if (!store_) store_.emplace(connection_);
    const NatsMessage message = store_->next_job(milliseconds(500));
    if (message == nullptr) return;
    const auto data = data_of(message);
    const Json job = Json::parse(data.begin(), data.end(), nullptr, false);
    const std::string words =
        std::string(natsMsg_GetSubject(message.get())).substr(std::string("cylpose.jobs.").size());
    const std::string archive = words.substr(0, words.find('.'));
    const std::optional<std::string> manifest = store_->find("cylpose.archive." + archive);
    if (manifest) store_->put_once("cylpose.poses." + words, result_of(*manifest, job, message));
    check(natsMsg_AckSync(message.get(), nullptr, nullptr), "natsMsg_AckSync");
  }

  // What cannot be done will not become possible by being tried again: the result says so.
  std::string result_of(const std::string& manifest, const Json& job, const NatsMessage& message) {
    try {
      const auto alive = [&] { natsMsg_InProgress(message.get(), nullptr); };
      return Json{{"poses", poses_of(backend_, Json::parse(manifest), job, alive)}}.dump();
    } catch (const Json::exception& error) {
      return Json{{"error", error.what()}}.dump();
    } catch (const Error& error) {
      if (error.kind() == ErrorKind::kDevice) throw;
      return Json{{"error", error.what()}}.dump();
    }
  }

  Backend& backend_;
  const Connection& connection_;
  const std::function<void(const std::string&)>& on_event_;
  std::optional<JobStore> store_;
};

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
    const std::string job = Json{{"first", first}, {"files", files}}.dump();
    patient.ask([&](JobStore& store) {
      if (!store.find(fmt::format("cylpose.poses.{}.{}", archive.name, number)))
        store.put_job(archive.name, number, job);
    });
  }
  return jobs;
}

void run_jobs(Backend& backend, const ConnectionOptions& options, const std::function<bool()>& stop,
              const std::function<void(const std::string&)>& on_event) {
  const Connection connection(options, "cylpose worker --jobs");
  JobWorker worker(backend, connection, on_event);
  while (!stop()) {
    if (connection.closed()) {
      throw Error(ErrorKind::kDevice, "the NATS server refuses us: " + connection.last_error());
    }
    worker.step();
  }
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
      std::this_thread::sleep_for(kRetry / 5);
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
  return jobs;
}

}  // namespace cylpose::cluster
