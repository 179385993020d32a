// Does the jobs of archives: frames in, the text of a poses file out.
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

  [[nodiscard]] std::filesystem::path write(const std::string& name, const std::string& bytes) const {
    std::ofstream file(path_ / name, std::ios::binary);
    file << bytes;
    file.close();
    if (!file) throw Error(ErrorKind::kOutput, (path_ / name).string() + ": cannot be written; is the disk full?");
    return path_ / name;
  }
  [[nodiscard]] std::filesystem::path file(const std::string& name) const { return path_ / name; }

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

/// A job, and all that is needed to do it.
// NOLINTNEXTLINE(bugprone-exception-escape): the JSON value's constructor promises not to throw
struct Task {
  NatsMessage message;
  std::string words;  ///< ARCHIVE.NUMBER
  std::optional<Folder> folder;
  Json manifest;
  std::int64_t first = 0;                    ///< number of its first frame
  std::vector<std::filesystem::path> files;  ///< images
};

// The text of a poses file. Calls `alive` after each frame.
std::string poses_of(Backend& backend, const Task& task, const std::function<void()>& alive) {
  const Folder& folder = *task.folder;
  const Json& manifest = task.manifest;
  const CameraModel camera = load_camera(folder.write("camera.yaml", manifest.at("camera").get<std::string>()));
  const std::vector<PartModel> parts = load_parts(folder.write("parts.yaml", manifest.at("parts").get<std::string>()));
  const auto estimator = make_estimator(camera, parts, std::make_unique<Borrowed>(backend));
  std::vector<std::string> names;
  names.reserve(parts.size());
  for (const PartModel& part : parts) names.push_back(part.name);
  PoseWriter writer(folder.file("poses"), static_cast<PoseFormat>(manifest.at("format").get<int>()), names);
  const auto fps = manifest.at("fps").get<double>();
  std::int64_t index = task.first;
  for (const std::filesystem::path& file : task.files) {
    FrameEstimate estimate;
    std::string error = "there is no such file: " + file.string();
    if (std::filesystem::is_regular_file(file)) {
      const std::optional<Frame> frame = open_frames({file.string()})->next();
      error = frame ? frame->error : "no image in " + file.string();
      if (error.empty()) estimate = estimator->estimate(view_of(frame->image));
    }
    if (!error.empty()) {
      PoseEstimate none;
      none.reason = error;
      estimate.parts.assign(parts.size(), none);
    }
    writer.write(index, static_cast<double>(index) / fps, estimate);
    ++index;
    alive();
  }
  writer.close();
  return text_of(folder.file("poses"));
}

class JobWorker {
 public:
  JobWorker(Backend& backend, const Connection& connection, const std::function<void(const std::string&)>& on_event)
      : backend_(backend), connection_(connection), on_event_(on_event) {}

  // A server that fails at any point leaves the job in the queue: it comes again.
  void step() {
    Task task;
    if (!guarded([&] { fetch(task); })) {
      constexpr milliseconds kRetry{250};
      std::this_thread::sleep_for(kRetry);
    }
    if (task.message == nullptr) return;
    const std::string result = result_of(task);
    guarded([&] { finish(task.words, result, task.message); });
  }

 private:
  // False when the server failed.
  bool guarded(const std::function<void()>& what) {
    if (!connection_.connected()) return false;
    try {
      if (!store_) store_.emplace(connection_);
      what();
      last_failure_.clear();
      return true;
    } catch (const Error& error) {
      if (error.kind() != ErrorKind::kDevice) throw;
      if (on_event_ && last_failure_ != error.what()) on_event_(error.what());
      last_failure_ = error.what();
      store_.reset();
      return false;
    }
  }

  void fetch(Task& task) {
    NatsMessage message = store_->next_job(milliseconds(500));
    if (message == nullptr) return;
    task.words = std::string(natsMsg_GetSubject(message.get())).substr(std::string_view(kJobSubjects).size());
    const auto manifest = store_->find("cylpose.archive." + task.words.substr(0, task.words.find('.')));
    const auto data = data_of(message);
    try {
      task.manifest = Json::parse(manifest.value_or("there is none"));
      read(Json::parse(data.begin(), data.end()), task, message);
      task.message = std::move(message);
    } catch (const Json::exception& error) {
      finish(task.words, Json{{"error", std::string("the job cannot be read: ") + error.what()}}.dump(), message);
    }
  }

  void read(const Json& job, Task& task, const NatsMessage& message) {
    const Folder& folder = task.folder.emplace();
    task.first = job.at("first").get<std::int64_t>();
    const auto names = job.at("files").get<std::vector<std::string>>();
    for (std::size_t i = 0; i < names.size(); ++i) {
      const std::filesystem::path name = names[i];
      if (!job.contains("messages")) {
        task.files.push_back(name);
        continue;
      }
      const auto bytes = store_->frame(task.words, i, job["messages"].at(i).get<int>());
      const std::string local = fmt::format("frame{}{}", i, name.extension().string());
      task.files.push_back(bytes ? folder.write(local, *bytes) : folder.file(local));
      natsMsg_InProgress(message.get(), nullptr);
    }
  }

  // What cannot be done will not become possible by being tried again: the result says so. But a device or disk that
  // fails is this worker's own trouble.
  std::string result_of(const Task& task) {
    std::string text;
    try {
      const auto alive = [&] { natsMsg_InProgress(task.message.get(), nullptr); };
      text = Json{{"poses", poses_of(backend_, task, alive)}}.dump();
    } catch (const Json::exception& error) {
      text = Json{{"error", error.what()}}.dump();
    } catch (const Error& error) {
      if (error.kind() != ErrorKind::kInput) {
        natsMsg_Nak(task.message.get(), nullptr);
        throw;
      }
      text = Json{{"error", error.what()}}.dump();
    }
    const std::size_t most = connection_.most_payload();
    if (most == 0 || text.size() + kHeaderBytes <= most) return text;
    return Json{
        {"error", fmt::format("its poses are {} bytes, more than the server takes; submit with fewer --job-frames",
                              text.size())}}
        .dump();
  }

  void finish(const std::string& words, const std::string& result, const NatsMessage& message) {
    store_->put_once("cylpose.poses." + words, result);
    check(natsMsg_AckSync(message.get(), nullptr, nullptr), "natsMsg_AckSync");
    store_->drop_frames(words);
  }

  Backend& backend_;
  const Connection& connection_;
  const std::function<void(const std::string&)>& on_event_;
  std::string last_failure_;
  std::optional<JobStore> store_;
};

}  // namespace

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

}  // namespace cylpose::cluster
