// A rim bulges, an occluder's edge does not.
#include "rounded_end.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

namespace cylpose {
namespace {

// Points every pixel along a curve across the direction `outward`, its height given by `height_px`.
template <typename Height>
std::vector<EdgePoint> points_on(const Eigen::Vector2d& outward, Height height_px) {
  std::mt19937 random(3);
  std::normal_distribution<double> noise(0, 0.1);
  std::vector<EdgePoint> points;
  for (int place = -8; place <= 8; ++place) {
    EdgePoint point;
    point.inward = -outward;
    point.position_px = Eigen::Vector2d(700, 300) + place * Eigen::Vector2d(-outward.y(), outward.x()) +
                        (height_px(place) + noise(random)) * outward;
    points.push_back(point);
  }
  return points;
}

class RoundedEnd : public ::testing::TestWithParam<double> {
 protected:
  const Eigen::Vector2d outward{std::cos(GetParam()), std::sin(GetParam())};
};

TEST_P(RoundedEnd, OfARimIsItsHeight) {
  const auto rim = points_on(outward, [](int place) { return 3 * std::sqrt(1 - place * place / 100.0); });
  EXPECT_NEAR(rounded_end_px(rim, outward), 3 - 3 * 0.6, 0.3);
}

TEST_P(RoundedEnd, OfAnOccludersEdgeIsNone) {
  EXPECT_EQ(rounded_end_px(points_on(outward, [](int) { return 0; }), outward), 0);
  EXPECT_EQ(rounded_end_px(points_on(outward, [](int place) { return 0.6 * place; }), outward), 0);
}

TEST_P(RoundedEnd, OfAHollowEdgeIsNone) {
  EXPECT_EQ(rounded_end_px(points_on(outward, [](int place) { return 0.03 * place * place; }), outward), 0);
}

TEST_P(RoundedEnd, NeedsPoints) {
  auto few = points_on(outward, [](int place) { return -0.1 * place * place; });
  EXPECT_GT(rounded_end_px(few, outward), 4);
  few.resize(5);
  EXPECT_EQ(rounded_end_px(few, outward), 0);
  EXPECT_EQ(rounded_end_px({}, outward), 0);
  EXPECT_EQ(rounded_end_px(std::vector<EdgePoint>(10, few[0]), outward), 0);
}

INSTANTIATE_TEST_SUITE_P(Directions, RoundedEnd, ::testing::Values(0.0, 0.7, 2.0, 4.0));

}  // namespace
}  // namespace cylpose
