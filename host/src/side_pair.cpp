#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cylpose/side_pair.hpp>
#include <numbers>

#include "option_check.hpp"

namespace cylpose {
namespace {

constexpr double kFacingTolerancePx = 1.5;
// Above this ratio of the region's axes its orientation says nothing about the part's.
constexpr double kMaxElongatedEccentricity = 0.5;
constexpr double kDeviationPenalty = 0.5;

// Both ends of each line lie on the inner side of the other.
bool inner_sides_face(const FittedLine& a, const FittedLine& b) {
  return signed_distance(a.line, b.from) > -kFacingTolerancePx && signed_distance(a.line, b.to) > -kFacingTolerancePx &&
         signed_distance(b.line, a.from) > -kFacingTolerancePx && signed_distance(b.line, a.to) > -kFacingTolerancePx;
}

// The least length, in metres, of a cylinder of this radius whose sides show these pieces: it is that long when its
// axis is perpendicular to the line of sight, longer else. (Far away the two lines alone tell the tilt too badly to say
// more.)
double least_length(const FittedLine& a, const FittedLine& b, double radius_m) {
  const std::array<Eigen::Vector2d, 4> ends = {a.from, a.to, b.from, b.to};
  const Eigen::Vector2d middle = (a.from + a.to + b.from + b.to) / 4;
  const double width_px = signed_distance(a.line, middle) + signed_distance(b.line, middle);
  const Eigen::Vector2d across = (a.line.normal - b.line.normal).normalized();
  double first = 0;
  double last = 0;
  for (const Eigen::Vector2d& end : ends) {
    const double along = across.x() * (end.y() - middle.y()) - across.y() * (end.x() - middle.x());
    first = std::min(first, along);
    last = std::max(last, along);
  }
  return (last - first) / width_px * 2 * radius_m;
}

// Angle between the image of the axis (midway between the sides) and the region's long axis, 0 to pi/2.
double axis_deviation(const FittedLine& a, const FittedLine& b, const RegionStatistics& region) {
  const Eigen::Vector2d middle_normal = (a.line.normal - b.line.normal).normalized();
  const double angle = std::atan2(middle_normal.x(), -middle_normal.y());
  const double difference = std::remainder(angle - region.orientation_rad(), std::numbers::pi);
  return std::abs(difference);
}

}  // namespace

bool SidePairOptions::is_valid(std::string* why) const {
  return require_at_least(max_lines, 2, "pair.max_lines", why) &&
         require_at_least(max_pairs, 1, "pair.max_pairs", why) &&
         require_positive(max_axis_deviation_rad, "pair.max_axis_deviation_rad", why) &&
         require_positive(max_length_factor, "pair.max_length_factor", why);
}

Eigen::Vector3d plane_of(const CameraModel& camera, const ImageLine& line) {
  const Eigen::Vector2d& n = line.normal;
  return Eigen::Vector3d(camera.fx * n.x(), camera.fy * n.y(), n.x() * camera.cx + n.y() * camera.cy - line.distance)
      .normalized();
}

std::vector<SidePair> rank_side_pairs(const CameraModel& camera, const PartModel& part, const RegionStatistics& region,
                                      std::span<const FittedLine> lines, const SidePairOptions& options) {
  const bool elongated = region.m00 > 0 && region.eccentricity() < kMaxElongatedEccentricity;
  const std::size_t count = std::min(lines.size(), static_cast<std::size_t>(options.max_lines));
  std::vector<SidePair> pairs;
  for (std::size_t i = 0; i < count; ++i) {
    for (std::size_t j = i + 1; j < count; ++j) {
      const FittedLine& a = lines[i];
      const FittedLine& b = lines[j];
      if (!inner_sides_face(a, b)) continue;
      const auto axis = axis_from_sides(plane_of(camera, a.line), plane_of(camera, b.line), part.radius_m);
      if (!axis) continue;
      if (least_length(a, b, part.radius_m) > options.max_length_factor * part.height_m) continue;

      const double straightness = 1 / (1 + a.rms_px + b.rms_px);
      const double support = static_cast<double>(a.points.size() + b.points.size());
      const bool deviates = elongated && axis_deviation(a, b, region) > options.max_axis_deviation_rad;
      pairs.push_back({static_cast<int>(i), static_cast<int>(j), *axis,
                       support * straightness * (deviates ? kDeviationPenalty : 1.0)});
    }
  }
  std::stable_sort(pairs.begin(), pairs.end(), [](const SidePair& a, const SidePair& b) { return a.score > b.score; });
  if (pairs.size() > static_cast<std::size_t>(options.max_pairs)) {
    pairs.resize(static_cast<std::size_t>(options.max_pairs));
  }
  return pairs;
}

}  // namespace cylpose
