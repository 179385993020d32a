#include <gtest/gtest.h>

#include <cylpose/axial.hpp>

#include "ideal_edges.hpp"

namespace cylpose {
namespace {

using testing::ideal_edges;
using testing::IdealEdges;
using testing::random_pose;
using testing::test_camera;
using testing::test_part;

class AxialTest : public ::testing::Test {
 protected:
  static AxisLine line_of(const CylinderPose& pose) {
    const Eigen::Vector3d& d = pose.axis_in_cam;
    return {pose.center_in_cam - d * d.dot(pose.center_in_cam), d};
  }

  std::vector<CylinderPose> candidates(const CylinderPose& pose, const IdealEdges& how = {}) const {
    const PartEdges edges = ideal_edges(camera, part, pose, how);
    return candidate_centers(camera, part, line_of(pose), edge_points(camera, edges.edges), edges.region, 3);
  }

  CameraModel camera = test_camera();
  PartModel part = test_part();
};

TEST_F(AxialTest, BasesGiveTheCentre) {
  std::mt19937 random(1);
  for (int i = 0; i < 100; ++i) {
    const CylinderPose pose = random_pose(random, part);
    const auto found = candidates(pose);
    ASSERT_FALSE(found.empty());
    EXPECT_LT((found.front().center_in_cam - pose.center_in_cam).norm(), 0.004) << i;
  }
}

TEST_F(AxialTest, OneBaseIsEnough) {
  std::mt19937 random(2);
  for (int i = 0; i < 50; ++i) {
    const CylinderPose pose = random_pose(random, part);
    const Eigen::Vector2d middle = ideal_pixel(camera, pose.center_in_cam);
    const Eigen::Vector2d up = (ideal_pixel(camera, pose.center_in_cam + 0.1 * pose.axis_in_cam) - middle).normalized();
    IdealEdges how;
    how.is_visible = [&](const Eigen::Vector2d& p) { return up.dot(p - middle) > 0; };
    const auto found = candidates(pose, how);
    ASSERT_FALSE(found.empty());
    EXPECT_LT((found.front().center_in_cam - pose.center_in_cam).norm(), 0.006) << i;
  }
}

TEST_F(AxialTest, WithoutBasesTheRegionsCentreOfMassGivesIt) {
  // Seen whole, but no edge given: the outline's centre of mass must compensate the perspective drift of the mean.
  const CylinderPose pose{{0.02, 0, 0.9}, Eigen::Vector3d(0.1, -0.8, 0.6).normalized()};
  const PartEdges edges = ideal_edges(camera, part, pose);
  const auto found = candidate_centers(camera, part, line_of(pose), {}, edges.region, 3);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_LT((found.front().center_in_cam - pose.center_in_cam).norm(), 0.003);
}

TEST_F(AxialTest, ALineBehindTheCameraHasNoCentre) {
  const PartEdges edges = ideal_edges(camera, part, {{0, 0, 2}, Eigen::Vector3d::UnitY()});
  const AxisLine behind{{0, 0, -2}, Eigen::Vector3d::UnitY()};
  EXPECT_TRUE(candidate_centers(camera, part, behind, {}, edges.region, 3).empty());
}

}  // namespace
}  // namespace cylpose
