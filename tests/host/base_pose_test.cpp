#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cylpose/base_pose.hpp>
#include <cylpose/pose.hpp>
#include <numeric>

#include "ideal_edges.hpp"

namespace cylpose {
namespace {

using testing::axis_angle;
using testing::ideal_edges;
using testing::IdealEdges;
using testing::test_camera;
using testing::test_part;

class BasePoseTest : public ::testing::Test {
 protected:
  // The near base of a cylinder that is seen `tilt` radians off its axis.
  CylinderPose tilted(double tilt, double distance_m) const {
    const Eigen::Vector3d center(0.1, -0.05, distance_m);
    const Eigen::Vector3d sight = center.normalized();
    return {center, Eigen::AngleAxisd(tilt, sight.unitOrthogonal()) * sight};
  }

  std::vector<EdgePoint> rim(const CylinderPose& pose, double noise_px, unsigned seed = 1) const {
    IdealEdges how;
    how.noise_px = noise_px;
    how.seed = seed;
    return edge_points(camera, ideal_edges(camera, part, pose, how).edges);
  }

  FittedEllipse fit(const std::vector<EdgePoint>& points) const {
    std::vector<Eigen::Vector2d> positions;
    for (const EdgePoint& point : points) positions.push_back(point.position_px);
    return refine_ellipse(fit_ellipse(positions).value(), points, {}).value();
  }

  CameraModel camera = test_camera();
  PartModel part = test_part();
};

TEST_F(BasePoseTest, OneOfThePosesIsTheCylinder) {
  // From the exact circle of either base.
  for (const double tilt : {0.2, 0.5, 1.0}) {
    const CylinderPose pose = tilted(tilt, 1.5);
    for (const double end : {-0.5, 0.5}) {
      const Eigen::Vector3d center = pose.center_in_cam + end * part.height_m * pose.axis_in_cam;
      const Eigen::Vector3d e1 = pose.axis_in_cam.unitOrthogonal();
      const Eigen::Vector3d e2 = pose.axis_in_cam.cross(e1);
      std::vector<Eigen::Vector2d> pixels;
      for (double angle = 0; angle < 6.2; angle += 0.1) {
        pixels.push_back(ideal_pixel(camera, center + part.radius_m * (std::cos(angle) * e1 + std::sin(angle) * e2)));
      }
      const FittedEllipse base{fit_ellipse(pixels).value(), {}, 0, {}};
      const auto poses = poses_from_bases(camera, part, {&base, 1});
      EXPECT_EQ(poses.size(), 4U);
      EXPECT_TRUE(std::ranges::any_of(poses, [&](const CylinderPose& candidate) {
        return (candidate.center_in_cam - pose.center_in_cam).norm() < 1e-6 &&
               axis_angle(candidate.axis_in_cam, pose.axis_in_cam) < 1e-6;
      })) << tilt;
    }
  }
}

TEST_F(BasePoseTest, EndOnTheTruthLiesWithinTheCovariance) {
  double center = 0;
  double axis = 0;
  constexpr unsigned kRuns = 100;
  for (unsigned seed = 0; seed < kRuns; ++seed) {
    const CylinderPose pose = tilted(0.02, 1);
    const std::vector<EdgePoint> points = rim(pose, 0.1, seed);
    const auto view = end_on_view(camera, part, fit(points), points, {.by_share_px = 0.03});
    ASSERT_TRUE(view);
    EXPECT_GT(view->seen, 0.95);
    EXPECT_GT(view->support, 0.95 * static_cast<double>(points.size()));
    const Eigen::Vector3d off = view->pose.center_in_cam - pose.center_in_cam;
    center += off.dot(view->covariance.topLeftCorner<3, 3>().ldlt().solve(off)) / kRuns;
    const double sigma = std::sqrt((view->covariance.bottomRightCorner<3, 3>().trace() - kUnobservableRoll) / 2);
    axis += std::pow(axis_angle(view->pose.axis_in_cam, pose.axis_in_cam) / sigma, 2) / kRuns;
  }
  EXPECT_LT(center, 1.3 * 3);
  EXPECT_GT(center, 0.1);
  EXPECT_LT(axis, 1.3 * 2);
}

TEST_F(BasePoseTest, ATiltedBaseWithoutItsSidesIsNoEndOnView) {
  const CylinderPose pose = tilted(0.3, 1);
  PartModel disc = part;
  disc.height_m = 1e-4;
  const std::vector<EdgePoint> points = edge_points(camera, ideal_edges(camera, disc, pose).edges);
  EXPECT_FALSE(end_on_view(camera, part, fit(points), points, {.by_share_px = 0.03}));
}

TEST_F(BasePoseTest, SeenCountsTheMissingArc) {
  const CylinderPose pose = tilted(0.01, 1);
  std::vector<EdgePoint> points = rim(pose, 0.05);
  const double middle = ideal_pixel(camera, pose.center_in_cam).x();
  std::erase_if(points, [&](const EdgePoint& p) { return p.position_px.x() > middle; });
  const auto view = end_on_view(camera, part, fit(points), points, {.by_share_px = 0.03});
  ASSERT_TRUE(view);
  EXPECT_NEAR(view->seen, 0.5, 0.1);
}

TEST_F(BasePoseTest, TheRegionsSpreadGivesTiltAndDistanceRoughly) {
  for (const double tilt : {0.1, 0.3, 0.45}) {
    const CylinderPose pose = tilted(tilt, 2);
    const auto poses = poses_from_blob(camera, part, ideal_edges(camera, part, pose).region);
    ASSERT_EQ(poses.size(), 2U);
    EXPECT_TRUE(std::ranges::any_of(poses, [&](const CylinderPose& candidate) {
      return (candidate.center_in_cam - pose.center_in_cam).norm() < 0.15 * 2 &&
             axis_angle(candidate.axis_in_cam, pose.axis_in_cam) < 0.15;
    })) << tilt;
  }
}

}  // namespace
}  // namespace cylpose
