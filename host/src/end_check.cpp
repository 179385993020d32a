#include "end_check.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cylpose/axial.hpp>
#include <cylpose/line.hpp>
#include <cylpose/refine.hpp>
#include <iterator>
#include <numeric>
#include <vector>

#include "rounded_end.hpp"

namespace cylpose {

std::optional<std::string> EndCheck::longer_part(const Outline& outline, std::size_t base,
                                                 std::span<const EdgePoint> points) const {
  const double beyond_px = std::min(overrun_px(outline, 0, base, points), overrun_px(outline, 1, base, points));
  const double length_px =
      (ideal_pixel(camera_, outline.end_of_side(0, 0)) - ideal_pixel(camera_, outline.end_of_side(0, 1))).norm();
  if (!(beyond_px > options_.check.max_overrun * length_px)) return std::nullopt;
  return fmt::format("the sides go on for {:.0f} px beyond the part's end", beyond_px);
}

std::optional<std::string> EndCheck::part_of_other_length(const CylinderPose& pose, std::size_t base,
                                                          std::span<const EdgePoint> unexplained) const {
  constexpr double kMinAxisCosine = 0.5;
  constexpr double kMinRimSeen = 0.5;
  constexpr double kMinBulgePx = 2;
  const Eigen::Vector3d& axis = pose.axis_in_cam;
  const double middle = axis.dot(pose.center_in_cam);
  const AxisLine line{pose.center_in_cam - middle * axis, axis};
  const Eigen::Vector3d step = axis * (part_.height_m / 100);
  const Eigen::Vector2d axis_image =
      (ideal_pixel(camera_, pose.center_in_cam + step) - ideal_pixel(camera_, pose.center_in_cam - step)).normalized();
  const double outward = base == 0 ? -1 : 1;
  std::vector<double> places;
  for (const EdgePoint& point : unexplained) {
    if (-outward * point.inward.dot(axis_image) < kMinAxisCosine) continue;
    const auto place = place_of_base(line, part_.radius_m, ideal_ray(camera_, point.position_px), base == 1);
    if (place) places.push_back(*place);
  }
  if (static_cast<int>(places.size()) < kMinSupport / 2) return std::nullopt;
  std::nth_element(places.begin(), places.begin() + static_cast<std::ptrdiff_t>(places.size() / 2), places.end());
  const double seen_end = places[places.size() / 2];
  const double other_end = middle - outward * part_.height_m / 2;
  PartModel other = part_;
  other.height_m = outward * (seen_end - other_end);
  if (!(other.height_m > 0)) return std::nullopt;
  const auto outline =
      Outline::of(camera_, other, {line.point_in_cam + (seen_end + other_end) / 2 * axis, pose.axis_in_cam});
  if (!outline) return std::nullopt;

  const std::size_t rim = kBase0 + base;
  const std::vector<Outline::Station> stations = outline->stations();
  std::vector<bool> seen(stations.size(), false);
  std::vector<EdgePoint> on_rim;
  double sum_px = 0;
  double squares_px = 0;
  for (const EdgePoint& point : unexplained) {
    const auto match = outline->match(point, options_.refine.final_gate_px);
    if (!match || match->piece != rim) continue;
    seen[outline->station_of(*match)] = true;
    on_rim.push_back(point);
    sum_px += match->distance_px;
    squares_px += match->distance_px * match->distance_px;
  }
  const auto on_rim_count = static_cast<double>(on_rim.size());
  const auto count = std::ranges::count(stations, static_cast<OutlinePiece>(rim), &Outline::Station::piece);
  const auto hits = static_cast<double>(std::count(seen.begin(), seen.end(), true));
  if (on_rim.size() < 3 || outline->bulge_px(base) < kMinBulgePx || hits < kMinRimSeen * static_cast<double>(count)) {
    return std::nullopt;
  }
  Chain all(on_rim.size());
  std::iota(all.begin(), all.end(), 0);
  const double mean_px = sum_px / on_rim_count;
  const double rms_to_rim_px = std::sqrt(std::max(0.0, squares_px / on_rim_count - mean_px * mean_px));
  if (!(rms_to_rim_px < fit_line(on_rim, all).rms_px)) return std::nullopt;
  return fmt::format("an end is seen at {:.3g} m of the other, the part is {:.3g} m long", other.height_m,
                     part_.height_m);
}

std::optional<std::string> EndCheck::end_inside(const Outline& outline, std::size_t base,
                                                std::span<const EdgePoint> unexplained) const {
  constexpr double kMinOutwardCosine = 0.5;
  constexpr double kMinBulgePx = 0.5;  // several times what edges of a straight border err
  const Eigen::Vector2d outward =
      (ideal_pixel(camera_, outline.end_of_side(0, base)) - ideal_pixel(camera_, outline.end_of_side(0, 1 - base)))
          .normalized();
  std::vector<EdgePoint> end;
  std::ranges::copy_if(unexplained, std::back_inserter(end), [&](const EdgePoint& point) {
    return -point.inward.dot(outward) > kMinOutwardCosine && outline.within(point.position_px, kClutterMarginPx);
  });
  const double bulge_px = rounded_end_px(end, outward);
  if (bulge_px < kMinBulgePx) return std::nullopt;
  return fmt::format("an end that bulges by {:.1f} px is seen where the part would go on", bulge_px);
}

double EndCheck::overrun_px(const Outline& outline, std::size_t side, std::size_t base,
                            std::span<const EdgePoint> points) const {
  const double gate_px = options_.refine.final_gate_px;
  constexpr double kMinSideCosine = 0.95;
  const ImageLine& line = outline.sides()[side];
  const Eigen::Vector2d end = ideal_pixel(camera_, outline.end_of_side(side, base));
  const Eigen::Vector2d onward = (end - ideal_pixel(camera_, outline.end_of_side(side, 1 - base))).normalized();
  return static_cast<double>(std::ranges::count_if(points, [&](const EdgePoint& point) {
    return onward.dot(point.position_px - end) > gate_px &&
           std::abs(signed_distance(line, point.position_px)) <= gate_px &&
           line.normal.dot(point.inward) > kMinSideCosine;
  }));
}

}  // namespace cylpose
