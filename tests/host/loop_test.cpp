#include "loop.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "ideal_edges.hpp"

namespace cylpose {
namespace {

// Points once around an ellipse, the colour inside or (a hole) outside.
std::vector<EdgePoint> around(const Eigen::Vector2d& middle, double half_width, double half_height, double turns,
                              bool hole) {
  std::vector<EdgePoint> points;
  for (int i = 0; i < 400; ++i) {
    const double angle = turns * 2 * std::numbers::pi * i / 400;
    const Eigen::Vector2d out(std::cos(angle) / half_width, std::sin(angle) / half_height);
    points.push_back({middle + Eigen::Vector2d(half_width * std::cos(angle), half_height * std::sin(angle)),
                      (hole ? 1 : -1) * out.normalized()});
  }
  return points;
}

Chain all_of(const std::vector<EdgePoint>& points) {
  Chain chain;
  for (std::size_t i = 0; i < points.size(); ++i) chain.push_back(static_cast<int>(i));
  return chain;
}

TEST(Loop, HasTheMomentsOfWhatItEncloses) {
  const auto points = around({300, 200}, 40, 25, 1, false);
  Chain chain = all_of(points);
  for (int i = 0; i < 2; ++i) {  // either way round
    const auto region = region_in_loop(points, chain);
    ASSERT_TRUE(region);
    const double area = std::numbers::pi * 40 * 25;
    EXPECT_NEAR(static_cast<double>(region->m00), area, 0.001 * area);
    EXPECT_NEAR(region->mean_x(), 300, 0.05);
    EXPECT_NEAR(region->mean_y(), 200, 0.05);
    EXPECT_NEAR(region->eccentricity(), 25. * 25 / (40 * 40), 0.01);
    EXPECT_NEAR(region->orientation_rad(), 0, 0.01);
    std::reverse(chain.begin(), chain.end());
  }
}

TEST(Loop, AgreesWithThePixelsOfAPart) {
  const CameraModel camera = testing::test_camera();
  const PartModel part = testing::test_part();
  const auto field =
      testing::ideal_edges(camera, part, {{0.2, 0.1, 1.5}, Eigen::Vector3d(0.6, -0.5, 0.4).normalized()});
  const auto points = edge_points(camera, field.edges);
  const auto chains = extract_chains(field.edges, 12);
  const auto longest = std::ranges::max_element(chains, {}, &Chain::size);
  const auto region = region_in_loop(points, *longest);
  ASSERT_TRUE(region);
  const auto area = static_cast<double>(field.region.m00);
  EXPECT_NEAR(static_cast<double>(region->m00), area, 0.03 * area);
  EXPECT_NEAR(region->mean_x(), field.region.mean_x(), 1);
  EXPECT_NEAR(region->orientation_rad(), field.region.orientation_rad(), 0.01);
}

TEST(Loop, NoneForOpenChainsAndHoles) {
  const auto open = around({300, 200}, 40, 25, 0.9, false);
  EXPECT_FALSE(region_in_loop(open, all_of(open)));
  const auto hole = around({300, 200}, 40, 25, 1, true);
  EXPECT_FALSE(region_in_loop(hole, all_of(hole)));
}

}  // namespace
}  // namespace cylpose
