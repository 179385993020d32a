#include <gtest/gtest.h>

#include <cmath>
#include <cylpose/edge_field.hpp>
#include <functional>
#include <numbers>

namespace cylpose {
namespace {

constexpr double kPi = std::numbers::pi;

// All pixels of a 1000 x 1000 frame that lie in the shape.
RegionStatistics statistics_of(const std::function<bool(double, double)>& contains) {
  RegionStatistics region;
  for (int y = 0; y < 1000; ++y) {
    for (int x = 0; x < 1000; ++x) {
      if (contains(x, y)) region.add(x, y);
    }
  }
  return region;
}

// Semi-axes a (along `angle`) and b, centre (500, 400).
RegionStatistics ellipse(double a, double b, double angle) {
  return statistics_of([=](double x, double y) {
    const double along = (x - 500) * std::cos(angle) + (y - 400) * std::sin(angle);
    const double across = (y - 400) * std::cos(angle) - (x - 500) * std::sin(angle);
    return along * along / (a * a) + across * across / (b * b) <= 1;
  });
}

TEST(RegionStatistics, RectangleHasItsMiddleAndOrientation) {
  const RegionStatistics lying =
      statistics_of([](double x, double y) { return x >= 100 && x < 180 && y >= 30 && y < 50; });
  EXPECT_EQ(lying.m00, 1600);
  EXPECT_DOUBLE_EQ(lying.mean_x(), 139.5);
  EXPECT_DOUBLE_EQ(lying.mean_y(), 39.5);
  EXPECT_NEAR(lying.orientation_rad(), 0, 1e-12);
  EXPECT_NEAR(lying.eccentricity(), (20.0 * 20 - 1) / (80.0 * 80 - 1), 1e-9);  // variances (n^2 - 1) / 12

  const RegionStatistics standing =
      statistics_of([](double x, double y) { return y >= 100 && y < 180 && x >= 30 && x < 50; });
  EXPECT_NEAR(std::abs(standing.orientation_rad()), kPi / 2, 1e-12);
}

TEST(RegionStatistics, EllipsesHaveTheOrientationAndEccentricityTheyWereDrawnWith) {
  for (double degrees = -85; degrees <= 90; degrees += 17.5) {
    const double angle = degrees * kPi / 180;
    const RegionStatistics region = ellipse(120, 40, angle);
    EXPECT_NEAR(region.mean_x(), 500, 0.05);
    EXPECT_NEAR(region.mean_y(), 400, 0.05);
    EXPECT_NEAR(std::remainder(region.orientation_rad() - angle, kPi), 0, 1e-3) << degrees;
    EXPECT_NEAR(region.eccentricity(), 1.0 / 9, 1e-3) << degrees;
  }
}

TEST(RegionStatistics, DiscIsRoundAndLineIsNot) {
  EXPECT_NEAR(ellipse(100, 100, 0).eccentricity(), 1, 1e-3);
  const RegionStatistics diagonal = statistics_of([](double x, double y) { return x == y; });
  EXPECT_NEAR(diagonal.eccentricity(), 0, 1e-9);
  EXPECT_NEAR(diagonal.orientation_rad(), kPi / 4, 1e-9);
  RegionStatistics point;
  point.add(7, 9);
  EXPECT_EQ(point.eccentricity(), 1);
}

TEST(RegionStatistics, MomentsOfTheLargestFrameDoNotOverflow) {
  RegionStatistics region;
  for (int x = 32000; x < 32767; ++x) region.add(x, 32766);
  EXPECT_GT(region.m20, 767LL * 32000 * 32000);
  EXPECT_EQ(region.m02, 767LL * 32766 * 32766);
  EXPECT_NEAR(region.orientation_rad(), 0, 1e-6);
}

}  // namespace
}  // namespace cylpose
