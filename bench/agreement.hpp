// Whether two backends gave the same answer: nothing is timed before it did.
#pragma once

#include <cylpose/edge_field.hpp>
#include <cylpose/pose.hpp>
#include <span>
#include <string>
#include <string_view>

namespace cylpose::bench {

/// How far a backend's answer may be from that of `serial`. All zero: equal to the last bit.
struct Tolerance {
  double mask_share = 0;    ///< mask pixels that differ, per mask pixel
  double edge_share = 0;    ///< strong edge pixels without one of the other backend within a pixel, per edge pixel
  double center_share = 0;  ///< distance of the centres, per distance of the centre from the camera
  double axis_rad = 0;      ///< angle between the axes

  [[nodiscard]] bool exact() const { return mask_share == 0 && edge_share == 0 && center_share == 0 && axis_rad == 0; }
};

/// What the backend promises. OpenCV's hue has steps of 1.4 degrees and its Canny other rules for weak edges; all
/// others promise equality.
[[nodiscard]] Tolerance tolerance_of(std::string_view backend);

/// What is too different, in words; empty where nothing is.
[[nodiscard]] std::string difference(const EdgeField& expected, const EdgeField& actual, const Tolerance& tolerance);

/// The same for poses.
[[nodiscard]] std::string difference(std::span<const PoseEstimate> expected, std::span<const PoseEstimate> actual,
                                     const Tolerance& tolerance);

}  // namespace cylpose::bench
