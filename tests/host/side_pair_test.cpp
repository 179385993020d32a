#include <gtest/gtest.h>

#include <cylpose/outline.hpp>
#include <cylpose/side_pair.hpp>

#include "ideal_edges.hpp"

namespace cylpose {
namespace {

using testing::axis_angle;
using testing::random_pose;
using testing::test_camera;
using testing::test_part;

// A line as if it had been fitted to `support` points between two image points.
FittedLine line_between(const Eigen::Vector2d& from, const Eigen::Vector2d& to, const Eigen::Vector2d& inside,
                        int support) {
  const Eigen::Vector2d along = (to - from).normalized();
  Eigen::Vector2d normal(-along.y(), along.x());
  if (normal.dot(inside - from) < 0) normal = -normal;
  FittedLine line;
  line.line = {normal, normal.dot(from)};
  line.rms_px = 0.1;
  line.points.resize(static_cast<std::size_t>(support));
  line.from = from;
  line.to = to;
  return line;
}

class SidePairTest : public ::testing::Test {
 protected:
  // The two sides of the pose as exact lines.
  std::vector<FittedLine> sides_of(const CylinderPose& pose) const {
    const auto planes = side_planes(pose, part.radius_m);
    const Eigen::Vector2d middle = ideal_pixel(camera, pose.center_in_cam);
    std::vector<FittedLine> lines;
    for (const Eigen::Vector3d& normal : *planes) {
      const Eigen::Vector3d touch = pose.center_in_cam - part.radius_m * normal;
      const Eigen::Vector3d half = pose.axis_in_cam * (part.height_m / 2);
      lines.push_back(line_between(ideal_pixel(camera, touch - half), ideal_pixel(camera, touch + half), middle, 100));
    }
    return lines;
  }

  std::vector<SidePair> rank(const std::vector<FittedLine>& lines, const RegionStatistics& region = {}) const {
    return rank_side_pairs(camera, part, region, lines, {});
  }

  CameraModel camera = test_camera();
  PartModel part = test_part();
};

TEST_F(SidePairTest, TwoSidesGiveTheirAxis) {
  std::mt19937 random(1);
  for (int i = 0; i < 100; ++i) {
    const CylinderPose pose = random_pose(random, part);
    const auto pairs = rank(sides_of(pose));
    ASSERT_EQ(pairs.size(), 1U) << i;
    EXPECT_LT(axis_angle(pairs[0].axis.direction_in_cam, pose.axis_in_cam), 1e-6);
    EXPECT_LT((pose.center_in_cam - pairs[0].axis.point_in_cam).cross(pose.axis_in_cam).norm(), 1e-6);
  }
}

TEST_F(SidePairTest, PlaneOfALineHoldsItsRays) {
  const FittedLine line = line_between({100, 200}, {500, 300}, {300, 100}, 10);
  const Eigen::Vector3d normal = plane_of(camera, line.line);
  EXPECT_NEAR(normal.norm(), 1, 1e-12);
  EXPECT_NEAR(normal.dot(ideal_ray(camera, {100, 200})), 0, 1e-12);
  EXPECT_NEAR(normal.dot(ideal_ray(camera, {500, 300})), 0, 1e-12);
  EXPECT_GT(normal.dot(ideal_ray(camera, {300, 100})), 0);
}

TEST_F(SidePairTest, LinesThatFaceAwayFromEachOtherAreNoPair) {
  std::vector<FittedLine> lines = sides_of({{0, 0, 2}, Eigen::Vector3d::UnitY()});
  for (FittedLine& line : lines) line.line = {-line.line.normal, -line.line.distance};
  EXPECT_TRUE(rank(lines).empty());
  lines = sides_of({{0, 0, 2}, Eigen::Vector3d::UnitY()});
  lines[1].line = {-lines[1].line.normal, -lines[1].line.distance};
  EXPECT_TRUE(rank(lines).empty());
}

TEST_F(SidePairTest, SidesLongerThanThePartAreNoPair) {
  std::vector<FittedLine> lines = sides_of({{0, 0, 2}, Eigen::Vector3d::UnitY()});
  for (FittedLine& line : lines) {
    const Eigen::Vector2d extra = 0.3 * (line.to - line.from);
    line.to += extra;
  }
  EXPECT_TRUE(rank(lines).empty());
}

TEST_F(SidePairTest, TheBestSupportedPairComesFirst) {
  std::vector<FittedLine> lines = sides_of({{0, 0, 2}, Eigen::Vector3d::UnitY()});
  // Two pieces of clutter, farther apart and less supported; both face inward.
  lines.push_back(line_between({560, 330}, {560, 380}, {640, 355}, 30));
  lines.push_back(line_between({720, 330}, {720, 380}, {640, 355}, 25));
  const auto pairs = rank(lines);
  ASSERT_GE(pairs.size(), 2U);
  EXPECT_EQ(pairs[0].first, 0);
  EXPECT_EQ(pairs[0].second, 1);
  for (std::size_t i = 1; i < pairs.size(); ++i) EXPECT_GE(pairs[i - 1].score, pairs[i].score);
}

TEST_F(SidePairTest, TheRegionsAxisDecidesBetweenEqualPairs) {
  // A region that is long in x; one pair along x, one across it.
  RegionStatistics region;
  for (int x = 400; x < 880; ++x) {
    for (int y = 330; y < 390; ++y) region.add(x, y);
  }
  const std::vector<FittedLine> lines = {
      line_between({610, 335}, {610, 385}, {640, 360}, 60), line_between({670, 335}, {670, 385}, {640, 360}, 60),
      line_between({620, 330}, {660, 330}, {640, 360}, 55), line_between({620, 390}, {660, 390}, {640, 360}, 55)};
  const auto pairs = rank(lines, region);
  ASSERT_FALSE(pairs.empty());
  EXPECT_EQ(pairs[0].first, 2);
  EXPECT_EQ(pairs[0].second, 3);
}

}  // namespace
}  // namespace cylpose
