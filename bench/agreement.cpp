#include "agreement.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <set>
#include <utility>
#include <vector>

namespace cylpose::bench {
namespace {

// 0 where there is nothing at all: both must then be empty.
double share(std::size_t count, std::size_t whole) {
  if (count == 0) return 0;
  return static_cast<double>(count) / static_cast<double>(std::max<std::size_t>(whole, 1));
}

std::size_t different_pixels(const Mask& a, const Mask& b) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < a.pixels.size(); ++i) count += a.pixels[i] != b.pixels[i] ? 1 : 0;
  return count;
}

std::vector<std::pair<int, int>> strong_places(const PartEdges& part) {
  std::vector<std::pair<int, int>> places;
  for (const EdgePixel& edge : part.edges) {
    if (edge.strength == EdgeStrength::kStrong) places.emplace_back(edge.x, edge.y);
  }
  return places;
}

double share_without_counterpart(const PartEdges& of, const PartEdges& among) {
  std::set<std::pair<int, int>> near;
  for (const auto& [x, y] : strong_places(among)) {
    for (int dy = -1; dy <= 1; ++dy) {
      for (int dx = -1; dx <= 1; ++dx) near.emplace(x + dx, y + dy);
    }
  }
  const std::vector<std::pair<int, int>> places = strong_places(of);
  const auto lone = std::ranges::count_if(places, [&](const auto& place) { return !near.contains(place); });
  return share(static_cast<std::size_t>(lone), places.size());
}

std::string exact_difference(const PartEdges& expected, const PartEdges& actual) {
  if (actual.region != expected.region) return "another area, box or moment";
  if (actual.edges != expected.edges) {
    return fmt::format("{} edge pixels, not the {} expected or not the same", actual.edges.size(),
                       expected.edges.size());
  }
  if (actual.mask.pixels != expected.mask.pixels) return "another mask";
  return {};
}

std::string difference_beyond(const Tolerance& tolerance, const PartEdges& expected, const PartEdges& actual) {
  const double mask =
      share(different_pixels(expected.mask, actual.mask), static_cast<std::size_t>(expected.region.m00));
  if (mask > tolerance.mask_share) return fmt::format("{:.4f} of the mask's pixels differ", mask);
  const double missed = share_without_counterpart(expected, actual);
  if (missed > tolerance.edge_share) return fmt::format("{:.4f} of the strong edge pixels are missing", missed);
  const double invented = share_without_counterpart(actual, expected);
  if (invented > tolerance.edge_share)
    return fmt::format("{:.4f} of the strong edge pixels are not expected", invented);
  return {};
}

std::string difference_of(const PoseEstimate& expected, const PoseEstimate& actual, const Tolerance& tolerance) {
  if (actual.status != expected.status) {
    return fmt::format("status {}, expected {}", to_string(actual.status), to_string(expected.status));
  }
  if (expected.status == PoseStatus::kNone) return {};
  const CylinderPose& a = expected.pose;
  const CylinderPose& b = actual.pose;
  if (tolerance.exact()) {
    const bool same = a.center_in_cam == b.center_in_cam && a.axis_in_cam == b.axis_in_cam &&
                      expected.covariance == actual.covariance && expected.support == actual.support;
    return same ? "" : "another pose, covariance or support";
  }
  // Negated, so that a NaN is a difference.
  const double center = (a.center_in_cam - b.center_in_cam).norm() / a.center_in_cam.norm();
  if (!(center <= tolerance.center_share)) return fmt::format("the centre is off by {:.5f} of its distance", center);
  const double angle =
      std::atan2(a.axis_in_cam.cross(b.axis_in_cam).norm(), std::abs(a.axis_in_cam.dot(b.axis_in_cam)));
  if (!(angle <= tolerance.axis_rad)) return fmt::format("the axis is off by {:.5f} rad", angle);
  return {};
}

}  // namespace

Tolerance tolerance_of(std::string_view backend) {
  if (backend == "opencv") return {0.002, 0.005, 0.0002, 0.001};
  return {};
}

std::string difference(const EdgeField& expected, const EdgeField& actual, const Tolerance& tolerance) {
  if (actual.searched != expected.searched) return "another region was searched";
  if (actual.parts.size() != expected.parts.size()) return "another number of parts";
  for (std::size_t i = 0; i < expected.parts.size(); ++i) {
    const PartEdges& a = expected.parts[i];
    const PartEdges& b = actual.parts[i];
    if (b.mask.roi != a.mask.roi || b.mask.pixels.size() != a.mask.pixels.size()) {
      return fmt::format("part {}: a mask of another region", i);
    }
    const std::string found = tolerance.exact() ? exact_difference(a, b) : difference_beyond(tolerance, a, b);
    if (!found.empty()) return fmt::format("part {}: {}", i, found);
  }
  return {};
}

std::string difference(std::span<const PoseEstimate> expected, std::span<const PoseEstimate> actual,
                       const Tolerance& tolerance) {
  if (actual.size() != expected.size()) return "another number of poses";
  for (std::size_t i = 0; i < expected.size(); ++i) {
    const std::string found = difference_of(expected[i], actual[i], tolerance);
    if (!found.empty()) return fmt::format("part {}: {}", i, found);
  }
  return {};
}

}  // namespace cylpose::bench
