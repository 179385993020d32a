// Which two lines are the two sides of one cylinder?
#pragma once

#include <cylpose/camera.hpp>
#include <cylpose/cylinder.hpp>
#include <cylpose/edge_field.hpp>
#include <cylpose/line.hpp>
#include <cylpose/part.hpp>
#include <span>
#include <string>
#include <vector>

namespace cylpose {

/// Two lines that can be the sides of the part, and the axis that follows from them.
struct SidePair {
  int first;  ///< index into the lines
  int second;
  AxisLine axis;
  double score;  ///< comparable within one call; higher is better
};

struct SidePairOptions {
  /// How many of the best supported lines are paired with each other. More survive heavier clutter; time grows squared.
  int max_lines = 12;
  /// How many pairs are returned at most.
  int max_pairs = 6;
  /// A pair whose axis image deviates more than this from the long axis of the colour region (radians) is rated lower
  /// (thesis: 35 degrees). Not a veto: an occluder or a second object of the colour turns the region's axis.
  double max_axis_deviation_rad = 0.61;
  /// How much longer than the part a cylinder must at least be to show these pieces of sides, as a factor. 1 would be
  /// exact; more allows for errors of short or blurred sides.
  double max_length_factor = 1.15;

  [[nodiscard]] bool is_valid(std::string* why) const;
};

/// Unit normal of the plane through the camera centre and the image line (ideal camera); the part is on its positive
/// side: n ~ K^T l (docs/algorithm.md).
[[nodiscard]] Eigen::Vector3d plane_of(const CameraModel& camera, const ImageLine& line);

/// The pairs that one cylinder of the part's radius and height can explain, best first: the inner sides of both lines
/// face each other (the axis then lies before the camera), and the pieces seen are no longer than the part. Rated by
/// support, straightness and agreement with the region's principal axis.
[[nodiscard]] std::vector<SidePair> rank_side_pairs(const CameraModel& camera, const PartModel& part,
                                                    const RegionStatistics& region, std::span<const FittedLine> lines,
                                                    const SidePairOptions& options);

}  // namespace cylpose
