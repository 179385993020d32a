#include "loop.hpp"

#include <cmath>

namespace cylpose {

std::optional<RegionStatistics> region_in_loop(std::span<const EdgePoint> points, const Chain& chain) {
  constexpr double kGapPx = 4;
  const auto at = [&](int i) -> const EdgePoint& { return points[static_cast<std::size_t>(i)]; };
  const Eigen::Vector2d origin = at(chain.front()).position_px;
  if ((at(chain.back()).position_px - origin).norm() > kGapPx) return std::nullopt;

  // Green's theorem, from the first point; triangles with it as a corner.
  double twice = 0;
  Eigen::Vector2d first = Eigen::Vector2d::Zero();
  Eigen::Matrix2d second = Eigen::Matrix2d::Zero();
  double color_on_left = 0;
  for (std::size_t i = 1; i < chain.size(); ++i) {
    const Eigen::Vector2d a = at(chain[i - 1]).position_px - origin;
    const Eigen::Vector2d b = at(chain[i]).position_px - origin;
    const double cross = a.x() * b.y() - a.y() * b.x();
    twice += cross;
    first += cross / 6 * (a + b);
    second += cross / 24 * (2 * a * a.transpose() + 2 * b * b.transpose() + a * b.transpose() + b * a.transpose());
    const Eigen::Vector2d& inward = at(chain[i]).inward;
    color_on_left += (b - a).x() * inward.y() - (b - a).y() * inward.x();
  }
  if (!(twice * color_on_left > 0)) return std::nullopt;
  RegionStatistics region;
  region.m00 = std::llround(std::abs(twice) / 2);
  if (region.m00 == 0) return std::nullopt;
  const auto area = static_cast<double>(region.m00);
  const Eigen::Vector2d offset = first / (twice / 2);
  const Eigen::Matrix2d covariance = second / (twice / 2) - offset * offset.transpose();
  region.m10 = std::llround(area * (origin + offset).x());
  region.m01 = std::llround(area * (origin + offset).y());
  // Of the mean as it is rounded: the covariance is a small difference of large numbers.
  const Eigen::Vector2d mean(region.mean_x(), region.mean_y());
  const Eigen::Matrix2d squares = area * (covariance + mean * mean.transpose());
  region.m20 = std::llround(squares(0, 0));
  region.m11 = std::llround(squares(0, 1));
  region.m02 = std::llround(squares(1, 1));
  return region;
}

}  // namespace cylpose
