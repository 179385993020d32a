// One picture per stage, to see where a pose comes from or where it is lost.
#pragma once

#include <cylpose/camera.hpp>
#include <cylpose/estimator.hpp>
#include <cylpose/part.hpp>
#include <cylpose/pose.hpp>
#include <opencv2/core/mat.hpp>
#include <span>
#include <string>
#include <vector>

namespace cylpose {

struct DebugPicture {
  std::string name;  ///< `<part>_<number>_<stage>`, as in candle_1_mask
  cv::Mat picture;   ///< BGR, of the frame's size
};

/// Seven pictures per part: 0_input (with the search region), 1_mask, 2_edges, 3_chains and 4_segments (each in a
/// colour of its own), 5_lines, 6_pose (the overlay of this part alone). The trace has one entry per part; stages that
/// it does not hold give pictures with nothing drawn.
[[nodiscard]] std::vector<DebugPicture> debug_pictures(const cv::Mat& image, const CameraModel& camera,
                                                       std::span<const PartModel> parts, const FrameEstimate& estimate,
                                                       const StageTrace& trace);

}  // namespace cylpose
