#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cylpose/error.hpp>
#include <cylpose/frame_pool.hpp>
#include <cylpose/frame_source.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/videoio.hpp>
#include <opencv2/videoio/registry.hpp>
#include <utility>

#include "image_file.hpp"
#include "input_files.hpp"
#include "text_file.hpp"

namespace cylpose {
namespace {

namespace fs = std::filesystem;

/// Image files. Timestamps come from the index, not by adding up, so that they carry no rounding drift.
class ImageSource final : public FrameSource {
 public:
  ImageSource(std::vector<fs::path> files, double fps) : files_(std::move(files)), fps_(fps) {}

  std::optional<Frame> next() override {
    if (next_ == files_.size()) return std::nullopt;
    const fs::path& file = files_[next_];
    Frame frame;
    frame.index = static_cast<std::int64_t>(next_);
    frame.timestamp_s = static_cast<double>(next_) / fps_;
    frame.name = file.string();
    try {
      frame.image = pool_.filled([&](cv::Mat& image) { read_image_file(file, image); });
    } catch (const Error& error) {
      frame.error = error.what();
    }
    ++next_;
    return frame;
  }

  std::optional<std::int64_t> size() const override { return static_cast<std::int64_t>(files_.size()); }
  double fps() const override { return fps_; }
  std::vector<std::string> warnings() const override { return {}; }

 private:
  std::vector<fs::path> files_;
  double fps_;
  FramePool pool_;
  std::size_t next_ = 0;
};

double stated_fps(const cv::VideoCapture& capture, double default_fps) {
  const double fps = capture.get(cv::CAP_PROP_FPS);
  return std::isfinite(fps) && fps > 0 ? fps : default_fps;
}

/// FFmpeg where OpenCV has it: left to itself OpenCV goes on to try libraries for still cameras with every file that is
/// no video, which takes seconds.
int file_reader() {
  return cv::videoio_registry::hasBackend(cv::CAP_FFMPEG) ? cv::CAP_FFMPEG : cv::CAP_ANY;
}

class VideoSource final : public FrameSource {
 public:
  VideoSource(const fs::path& file, double default_fps) : name_(file.string()), capture_(name_, file_reader()) {
    if (!capture_.isOpened()) {
      throw Error(ErrorKind::kInput,
                  fmt::format("{}: is neither an image nor a video that can be opened; is it whole?", name_));
    }
    fps_ = stated_fps(capture_, default_fps);
    const double count = capture_.get(cv::CAP_PROP_FRAME_COUNT);
    if (std::isfinite(count) && count >= 1) expected_ = static_cast<std::int64_t>(count);
  }

  std::optional<Frame> next() override {
    Frame frame;
    frame.image = pool_.filled([this](cv::Mat& image) { capture_.read(image); });
    if (frame.image.empty()) {
      if (delivered_ == 0) {
        throw Error(ErrorKind::kInput, fmt::format("{}: not one frame can be decoded; is the video whole?", name_));
      }
      ended_ = true;
      return std::nullopt;
    }
    frame.index = delivered_++;
    frame.timestamp_s = static_cast<double>(frame.index) / fps_;
    frame.name = fmt::format("{}, frame {}", name_, frame.index);
    return frame;
  }

  std::optional<std::int64_t> size() const override { return expected_; }
  double fps() const override { return fps_; }

  std::vector<std::string> warnings() const override {
    // Containers without an index estimate the count from the duration, which may be one off.
    if (!ended_ || !expected_ || delivered_ + 1 >= *expected_) return {};
    return {fmt::format("{}: ended after {} of {} frames; the video is cut short or damaged", name_, delivered_,
                        *expected_)};
  }

 private:
  std::string name_;
  FramePool pool_;
  cv::VideoCapture capture_;
  double fps_ = 0;
  std::optional<std::int64_t> expected_;
  std::int64_t delivered_ = 0;
  bool ended_ = false;
};

class CameraSource final : public FrameSource {
 public:
  CameraSource(std::string name, const cv::VideoCapture& capture, double default_fps)
      : name_(std::move(name)), capture_(capture) {
    if (!capture_.isOpened()) {
      throw Error(ErrorKind::kDevice, fmt::format("{}: the camera cannot be opened; is it connected, free and readable "
                                                  "for you?",
                                                  name_));
    }
    fps_ = stated_fps(capture_, default_fps);
  }

  std::optional<Frame> next() override {
    Frame frame;
    frame.image = pool_.filled([this](cv::Mat& image) { capture_.read(image); });
    if (frame.image.empty()) {
      throw Error(ErrorKind::kDevice,
                  fmt::format("{}: the camera gives no more frames after {}; was it disconnected?", name_, delivered_));
    }
    const auto now = std::chrono::steady_clock::now();
    if (delivered_ == 0) start_ = now;
    frame.index = delivered_++;
    frame.timestamp_s = std::chrono::duration<double>(now - start_).count();
    frame.name = fmt::format("{}, frame {}", name_, frame.index);
    return frame;
  }

  std::optional<std::int64_t> size() const override { return std::nullopt; }
  double fps() const override { return fps_; }
  std::vector<std::string> warnings() const override { return {}; }

 private:
  std::string name_;
  FramePool pool_;
  cv::VideoCapture capture_;
  double fps_ = 0;
  std::chrono::steady_clock::time_point start_;
  std::int64_t delivered_ = 0;
};

/// Several sources as one; frames are numbered through, and each source starts one frame after the last one's end.
class ChainedSource final : public FrameSource {
 public:
  explicit ChainedSource(std::vector<std::unique_ptr<FrameSource>> sources) : sources_(std::move(sources)) {}

  std::optional<Frame> next() override {
    while (current_ < sources_.size()) {
      if (std::optional<Frame> frame = sources_[current_]->next()) {
        frame->index = delivered_++;
        frame->timestamp_s += start_s_;
        last_s_ = frame->timestamp_s;
        return frame;
      }
      start_s_ = last_s_ + 1 / sources_[current_]->fps();
      ++current_;
    }
    return std::nullopt;
  }

  std::optional<std::int64_t> size() const override {
    std::int64_t sum = 0;
    for (const auto& source : sources_) {
      const auto size = source->size();
      if (!size) return std::nullopt;
      sum += *size;
    }
    return sum;
  }

  double fps() const override { return sources_.front()->fps(); }

  std::vector<std::string> warnings() const override {
    std::vector<std::string> all;
    for (const auto& source : sources_) {
      std::vector<std::string> some = source->warnings();
      std::move(some.begin(), some.end(), std::back_inserter(all));
    }
    return all;
  }

 private:
  std::vector<std::unique_ptr<FrameSource>> sources_;
  std::size_t current_ = 0;
  std::int64_t delivered_ = 0;
  double start_s_ = 0;
  double last_s_ = 0;
};

/// Collects sources; image files that follow one another become one source.
class SourceList {
 public:
  explicit SourceList(const FrameSourceOptions& options) : options_(options) {}

  void add(const std::string& input) {
    std::error_code ignored;
    const fs::path path(input);
    const fs::file_status status = fs::status(path, ignored);
    if (fs::is_directory(status)) {
      for (fs::path& file : images_in_folder(path)) images_.push_back(std::move(file));
    } else if (fs::is_character_file(status)) {
      add_source(std::make_unique<CameraSource>(input, cv::VideoCapture(input, cv::CAP_V4L2), options_.fps));
    } else if (fs::exists(status)) {
      add_file(path);
    } else if (const auto number = parse_integer(input); number && *number >= 0 && *number < 1000) {
      add_source(std::make_unique<CameraSource>(
          "camera " + input, cv::VideoCapture(static_cast<int>(*number), cv::CAP_V4L2), options_.fps));
    } else if (is_printf_pattern(input)) {
      for (fs::path& file : files_of_printf_pattern(input)) images_.push_back(std::move(file));
    } else if (is_glob(input)) {
      for (const fs::path& file : files_of_glob(input)) add(file.string());
    } else {
      throw Error(ErrorKind::kInput, fmt::format("{}: no such file, folder or camera; check the path", input));
    }
  }

  std::unique_ptr<FrameSource> finished() {
    finish_images();
    if (sources_.empty()) throw Error(ErrorKind::kInput, "no input; give images, a folder, a video or a camera");
    if (sources_.size() == 1) return std::move(sources_.front());
    return std::make_unique<ChainedSource>(std::move(sources_));
  }

 private:
  void add_file(const fs::path& file) {
    // By extension first: an image that is empty or damaged is still meant as an image.
    if (has_image_extension(file) || cv::haveImageReader(file.string())) {
      images_.push_back(file);
    } else {
      add_source(std::make_unique<VideoSource>(file, options_.fps));
    }
  }

  void add_source(std::unique_ptr<FrameSource> source) {
    finish_images();
    sources_.push_back(std::move(source));
  }

  void finish_images() {
    if (!images_.empty()) sources_.push_back(std::make_unique<ImageSource>(std::exchange(images_, {}), options_.fps));
  }

  FrameSourceOptions options_;
  std::vector<fs::path> images_;
  std::vector<std::unique_ptr<FrameSource>> sources_;
};

}  // namespace

bool FrameSourceOptions::is_valid(std::string* why) const {
  if (std::isfinite(fps) && fps > 0) return true;
  if (why != nullptr) *why = fmt::format("fps is {}; give frames per second above 0", fps);
  return false;
}

std::unique_ptr<FrameSource> open_frames(const std::vector<std::string>& inputs, const FrameSourceOptions& options) {
  std::string why;
  if (!options.is_valid(&why)) throw Error(ErrorKind::kInput, why);
  SourceList list(options);
  for (const std::string& input : inputs) list.add(input);
  return list.finished();
}

std::vector<std::string> image_files(const std::vector<std::string>& inputs) {
  std::vector<std::string> files;
  const auto add = [&](const std::vector<fs::path>& found) {
    for (const fs::path& file : found) files.push_back(file.string());
  };
  for (const std::string& input : inputs) {
    if (fs::is_directory(input)) {
      add(images_in_folder(input));
    } else if (fs::is_regular_file(input)) {
      if (!cv::haveImageReader(input)) {
        throw Error(ErrorKind::kInput, input + ": no image file; write a video's frames to image files first");
      }
      add({input});
    } else if (is_printf_pattern(input)) {
      add(files_of_printf_pattern(input));
    } else if (is_glob(input)) {
      add(files_of_glob(input));
    } else {
      throw Error(ErrorKind::kInput, input + ": no such image file, folder or pattern");
    }
  }
  return files;
}

}  // namespace cylpose
