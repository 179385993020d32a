// A folder with a camera file, a part file and pictures of a red cylinder, as a user would have it.
#pragma once

#include <cylpose/cylinder.hpp>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "../host/temp_dir.hpp"
#include "command.hpp"

namespace cylpose {

/// A 320 x 240 picture of the cylinder (radius 0.05 m, height 0.3 m) before a grey wall, focal length 400 pixels.
cv::Mat picture_of(const CylinderPose& pose);

/// An upright cylinder 1.2 m away, moved to the right by a centimetre per frame.
CylinderPose pose_of_frame(int frame);

class SceneTest : public testing::Test {
 protected:
  SceneTest();

  [[nodiscard]] std::string path(const std::string& name) const { return (folder_.path() / name).string(); }

  /// Writes text and returns the path.
  [[nodiscard]] std::string file(const std::string& name, std::string_view text) const {
    return folder_.write(name, text).string();
  }

  /// Writes frame_0000.png and so on into the folder `frames`.
  void write_frames(int count) const;

  /// Writes a video and returns its path.
  [[nodiscard]] std::string write_video(const std::string& name, int frames) const;

  /// `cylpose estimate` with this folder's camera and part files.
  [[nodiscard]] std::vector<std::string> estimate_words(const std::vector<std::string>& more) const;
  [[nodiscard]] CommandResult estimate(const std::vector<std::string>& more) const {
    return run_cylpose(estimate_words(more), folder_.path());
  }
  [[nodiscard]] CommandResult run(const std::vector<std::string>& arguments) const {
    return run_cylpose(arguments, folder_.path());
  }

  TempDir folder_;
  std::string camera_;  ///< path of the camera file
  std::string parts_;   ///< path of the part file
};

inline constexpr const char* kCameraText =
    "image_width: 320\nimage_height: 240\ncamera_matrix:\n  rows: 3\n  cols: 3\n"
    "  data: [400, 0, 160, 0, 400, 120, 0, 0, 1]\ndistortion_model: none\n";
inline constexpr const char* kPartsText =
    "parts:\n  - {name: can, radius_m: 0.05, height_m: 0.3, hue_deg: [340, 20], min_saturation: 0.4, min_value: 0.2}\n";

/// `text` with `from` replaced by `to`; fails the test when `from` is not in it.
std::string replaced(std::string text, const std::string& from, const std::string& to);

}  // namespace cylpose
