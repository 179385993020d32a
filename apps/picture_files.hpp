// Pictures that a run leaves behind: overlays and debug pictures.
#pragma once

#include <cstdint>
#include <filesystem>
#include <opencv2/core/mat.hpp>
#include <opencv2/videoio.hpp>
#include <optional>
#include <string>

namespace cylpose::apps {

/// Numbered PNG files in a folder that is made when it is not there.
class PictureFolder {
 public:
  /// Throws Error(kOutput) when the folder cannot be made.
  explicit PictureFolder(std::filesystem::path folder);

  /// Writes `frame_<number>[_<suffix>].png`. Throws Error(kOutput) that names the file.
  void write(std::int64_t frame, const std::string& suffix, const cv::Mat& picture) const;

 private:
  std::filesystem::path folder_;
};

/// Overlays, as pictures in a folder or as a video, by the destination's name: .mp4, .avi, .mkv and .mov are videos.
class OverlaySink {
 public:
  /// Throws Error(kOutput) when the folder or video cannot be made.
  OverlaySink(const std::filesystem::path& destination, double fps, cv::Size size);

  void write(std::int64_t frame, const cv::Mat& picture);

 private:
  std::optional<PictureFolder> folder_;
  cv::VideoWriter video_;
};

}  // namespace cylpose::apps
