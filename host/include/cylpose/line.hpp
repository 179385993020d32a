// Straight lines fitted into edge points, and the merging of lines that are one.
#pragma once

#include <Eigen/Core>
#include <cylpose/contour.hpp>
#include <cylpose/image_line.hpp>
#include <span>
#include <string>
#include <vector>

namespace cylpose {

/// A straight piece of the part's border, in pixels of the ideal camera.
struct FittedLine {
  ImageLine line;        ///< the normal points into the part
  double rms_px = 0;     ///< of the distances of its points
  Chain points;          ///< indices of the edge points it was fitted to
  Eigen::Vector2d from;  ///< first and last foot point on the line, in the order of the direction (ny, -nx)
  Eigen::Vector2d to;
};

struct LineOptions {
  /// Root mean square distance, in pixels, up to which a segment counts as straight. Larger takes arcs for lines.
  double max_rms_px = 0.7;
  /// Lines whose directions differ by less may be one line (radians).
  double merge_angle_rad = 0.05;
  /// ... if the line through the points of both fits them as well as this (pixels).
  double merge_rms_px = 0.7;

  [[nodiscard]] bool is_valid(std::string* why) const;
};

/// Total least squares line through the points (both coordinates have errors, so vertical lines are like any other):
/// the normal is the eigenvector of the scatter matrix with the smaller eigenvalue. Points farther than three times the
/// rms are left out once. Requires two points or more.
[[nodiscard]] FittedLine fit_line(std::span<const EdgePoint> points, const Chain& chain);

/// Lines through the segments that are straight; equal ones merged, also across the gap that an occluder leaves.
/// In order of falling support.
[[nodiscard]] std::vector<FittedLine> find_lines(std::span<const EdgePoint> points, std::span<const Chain> segments,
                                                 const LineOptions& options);

}  // namespace cylpose
