#include "picture_files.hpp"

#include <fmt/format.h>

#include <cylpose/error.hpp>
#include <opencv2/imgcodecs.hpp>
#include <system_error>
#include <utility>

namespace cylpose::apps {
namespace {

bool is_video(const std::filesystem::path& path) {
  const std::filesystem::path extension = path.extension();
  return extension == ".mp4" || extension == ".avi" || extension == ".mkv" || extension == ".mov";
}

}  // namespace

PictureFolder::PictureFolder(std::filesystem::path folder) : folder_(std::move(folder)) {
  std::error_code error;
  std::filesystem::create_directories(folder_, error);
  if (error || !std::filesystem::is_directory(folder_)) {
    throw Error(ErrorKind::kOutput, fmt::format("{}: the folder cannot be made: {}", folder_.string(),
                                                error ? error.message() : "a file of that name is in the way"));
  }
}

void PictureFolder::write(std::int64_t frame, const std::string& suffix, const cv::Mat& picture) const {
  const std::filesystem::path file =
      folder_ / fmt::format("frame_{:04}{}{}.png", frame, suffix.empty() ? "" : "_", suffix);
  bool written = false;
  std::string reason = "is the folder writable, and is there room?";
  try {
    written = cv::imwrite(file.string(), picture);
  } catch (const cv::Exception& error) {
    reason = error.err;
  }
  if (!written) {
    throw Error(ErrorKind::kOutput, fmt::format("{}: the picture cannot be written: {}", file.string(), reason));
  }
}

OverlaySink::OverlaySink(const std::filesystem::path& destination, double fps, cv::Size size) {
  if (!is_video(destination)) {
    folder_.emplace(destination);
    return;
  }
  const int codec = destination.extension() == ".avi" ? cv::VideoWriter::fourcc('M', 'J', 'P', 'G')
                                                      : cv::VideoWriter::fourcc('m', 'p', '4', 'v');
  video_.open(destination.string(), codec, fps, size);
  if (!video_.isOpened()) {
    throw Error(ErrorKind::kOutput, fmt::format("{}: the video cannot be written; choose a place that exists and is "
                                                "writable, or a folder for single pictures",
                                                destination.string()));
  }
}

void OverlaySink::write(std::int64_t frame, const cv::Mat& picture) {
  if (folder_) {
    folder_->write(frame, "", picture);
  } else {
    video_.write(picture);
  }
}

}  // namespace cylpose::apps
