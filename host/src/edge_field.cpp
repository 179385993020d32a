#include <algorithm>
#include <cmath>
#include <cylpose/edge_field.hpp>

namespace cylpose {
namespace {

// Central moments of order 2, divided by the area: the covariance of the pixel positions.
struct Covariance {
  double xx, xy, yy;
};

Covariance covariance_of(const RegionStatistics& region) {
  const double mean_x = region.mean_x();
  const double mean_y = region.mean_y();
  const auto area = static_cast<double>(region.m00);
  return {static_cast<double>(region.m20) / area - mean_x * mean_x,
          static_cast<double>(region.m11) / area - mean_x * mean_y,
          static_cast<double>(region.m02) / area - mean_y * mean_y};
}

}  // namespace

void RegionStatistics::add(int x, int y) {
  const std::int64_t wide_x = x;
  const std::int64_t wide_y = y;
  m00 += 1;
  m10 += wide_x;
  m01 += wide_y;
  m20 += wide_x * wide_x;
  m11 += wide_x * wide_y;
  m02 += wide_y * wide_y;
}

double RegionStatistics::mean_x() const {
  return static_cast<double>(m10) / static_cast<double>(m00);
}

double RegionStatistics::mean_y() const {
  return static_cast<double>(m01) / static_cast<double>(m00);
}

double RegionStatistics::orientation_rad() const {
  const Covariance c = covariance_of(*this);
  return std::atan2(2 * c.xy, c.xx - c.yy) / 2;
}

double RegionStatistics::eccentricity() const {
  const Covariance c = covariance_of(*this);
  const double middle = (c.xx + c.yy) / 2;
  const double half_spread = std::hypot(c.xy, (c.xx - c.yy) / 2);
  const double largest = middle + half_spread;
  return largest > 0 ? std::max(0.0, middle - half_spread) / largest : 1.0;
}

}  // namespace cylpose
