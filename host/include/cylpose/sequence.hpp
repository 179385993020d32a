// A scenario as files: pictures, truth, camera and parts in one folder, as a recording would come with its calibration.
#pragma once

#include <cstdint>
#include <cylpose/cylinder.hpp>
#include <cylpose/scenario.hpp>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace cylpose {

/// Writes `frame,cx,cy,cz,ax,ay,az` with one row per pose: metres, camera frame, axis sign by with_fixed_sign. Row i is
/// frame i. Throws Error(kOutput).
void save_truth(const std::vector<CylinderPose>& poses, const std::filesystem::path& path);

struct SequenceOptions {
  int frames = 1;  ///< at least 1, at most 10000: names have four digits
  double blur_sigma_px = 0.6;
  double noise_sigma = 1.5;  ///< code values
  std::uint64_t seed = 1;    ///< of the noise; every frame derives its own from it
  bool video = false;  ///< also video.mp4 (MPEG-4 part 2), or video.avi (Motion JPEG) where OpenCV cannot write that

  [[nodiscard]] bool is_valid(std::string* why) const;
};

/// The options with which the scenario is meant to be seen.
[[nodiscard]] SequenceOptions default_options(const Scenario& scenario);

/// One picture of the sequence: CV_8UC3, B G R.
[[nodiscard]] cv::Mat sequence_frame(const Scenario& scenario, const SequenceOptions& options, int frame);

/// Writes frame_0000.png ..., truth.csv, camera.yaml, parts.yaml and, on request, the video into `folder`, which is
/// made if need be; frames with the numbers that follow, left from a longer sequence, are removed. Calls `progress`
/// after every frame with the number of frames done; false ends the sequence there, with truth for the frames that
/// exist. Returns the files other than the frames. Throws Error(kOutput), Error(kInput) for options out of range.
std::vector<std::filesystem::path> write_sequence(const Scenario& scenario, const SequenceOptions& options,
                                                  const std::filesystem::path& folder,
                                                  const std::function<bool(int)>& progress);

}  // namespace cylpose
