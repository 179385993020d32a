// Straight lines in the image.
#pragma once

#include <Eigen/Core>

namespace cylpose {

/// An image line in pixels: all (x, y) with normal . (x, y) = distance; |normal| = 1. Where the line bounds something,
/// the normal points into it.
struct ImageLine {
  Eigen::Vector2d normal;
  double distance;
};

/// Distance of a point from the line in pixels, positive on the side that the normal points to.
[[nodiscard]] inline double signed_distance(const ImageLine& line, const Eigen::Vector2d& point) {
  return line.normal.dot(point) - line.distance;
}

}  // namespace cylpose
