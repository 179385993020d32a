#include <gtest/gtest.h>

#include <cylpose/pose.hpp>
#include <cylpose/refine.hpp>

#include "ideal_edges.hpp"

namespace cylpose {
namespace {

using testing::axis_angle;
using testing::ideal_edges;
using testing::IdealEdges;
using testing::random_pose;
using testing::test_camera;
using testing::test_part;

class RefineTest : public ::testing::Test {
 protected:
  std::vector<EdgePoint> points_of(const CylinderPose& pose, const IdealEdges& how = {}) const {
    return edge_points(camera, ideal_edges(camera, part, pose, how).edges);
  }

  CameraModel camera = test_camera();
  PartModel part = test_part();
};

// The closed form's typical error: a percent of the distance, a degree of tilt.
CylinderPose disturbed(const CylinderPose& pose, std::mt19937& random) {
  std::normal_distribution<double> unit(0, 1);
  const Eigen::Vector3d turn = 0.01 * Eigen::Vector3d(unit(random), unit(random), unit(random));
  const double z = pose.center_in_cam.z();
  return {pose.center_in_cam + 0.001 * z * Eigen::Vector3d(unit(random), unit(random), 5 * unit(random)),
          (pose.axis_in_cam + turn.cross(pose.axis_in_cam)).normalized()};
}

TEST_F(RefineTest, FindsBackFromADisturbedStart) {
  std::mt19937 random(1);
  for (int i = 0; i < 100; ++i) {
    const CylinderPose pose = random_pose(random, part);
    const auto refined = refine(camera, part, disturbed(pose, random), points_of(pose), {});
    ASSERT_TRUE(refined) << i;
    EXPECT_LT((refined->pose.center_in_cam - pose.center_in_cam).norm(), 1e-3 * pose.center_in_cam.z()) << i;
    EXPECT_LT(refined->rms_px, 0.05) << i;
    for (const double seen : refined->piece_seen) EXPECT_GT(seen, 0.6) << i;
  }
}

TEST_F(RefineTest, OutliersDoNotPull) {
  std::mt19937 random(2);
  const CylinderPose pose{{0, 0, 1.5}, Eigen::Vector3d(0.3, -1, 0.3).normalized()};
  auto points = points_of(pose);
  for (std::size_t i = 0; i < points.size(); i += 5) points[i].position_px += 1.2 * points[i].inward;
  const auto refined = refine(camera, part, pose, points, {});
  ASSERT_TRUE(refined);
  EXPECT_LT((refined->pose.center_in_cam - pose.center_in_cam).norm(), 1e-3);
}

TEST_F(RefineTest, CovarianceShrinksWithDistanceAndNoise) {
  RefineOptions options;
  options.common_edge_sigma.by_share_px = 0.001;  // which noise does not change
  const auto depth_sigma = [&](double z, double noise) {
    const CylinderPose pose{{0, 0, z}, Eigen::Vector3d(0.2, -1, 0.3).normalized()};
    IdealEdges how;
    how.noise_px = noise;
    const auto refined = refine(camera, part, pose, points_of(pose, how), options);
    return refined ? std::sqrt(refined->covariance(2, 2)) : -1.0;
  };
  EXPECT_GT(depth_sigma(1, 0.2), 0);
  EXPECT_GT(depth_sigma(3, 0.2), 4 * depth_sigma(1, 0.2));
  EXPECT_GT(depth_sigma(2, 0.4), 1.5 * depth_sigma(2, 0.1));
}

// Of edges that all have one cue and hardly scatter.
class CueTest : public RefineTest {
 protected:
  [[nodiscard]] double depth_sigma(EdgeCue cue, double distance_m = 2) const {
    const CylinderPose pose{{0, 0, distance_m}, Eigen::Vector3d(0.1, -1, 0.3).normalized()};
    IdealEdges how;
    how.noise_px = 0.02;
    auto points = points_of(pose, how);
    for (EdgePoint& point : points) point.cue = cue;
    const auto refined = refine(camera, part, pose, points, {});
    return refined ? std::sqrt(refined->covariance(2, 2)) : 0.0;
  }
};

TEST_F(CueTest, CovarianceGrowsWithWhatEdgesOfACueHaveInCommon) {
  const double by_limb = depth_sigma(EdgeCue::kLimb);
  ASSERT_GT(by_limb, 0);
  // The points' own scatter is small beside it, but for the background's share.
  const CommonEdgeSigma sigma;
  EXPECT_LT(depth_sigma(EdgeCue::kShare), 0.5 * by_limb);
  EXPECT_NEAR(depth_sigma(EdgeCue::kSlope) / by_limb, sigma.by_slope_px / sigma.by_limb_px, 0.3);
  EXPECT_NEAR(depth_sigma(EdgeCue::kNone) / by_limb, sigma.by_none_px / sigma.by_limb_px, 0.6);
}

// Errors near a piece's ends count for less on longer pieces: the part's width tells its depth, twice as wide and twice
// as long four times as well and, with the points' scatter alone, half as much again.
TEST_F(CueTest, WhatEdgesHaveInCommonAveragesOutOverLongPieces) {
  const double near = depth_sigma(EdgeCue::kSlope, 1.5);
  ASSERT_GT(near, 0);
  EXPECT_GT(depth_sigma(EdgeCue::kSlope, 3) / near, 5);
  EXPECT_LT(depth_sigma(EdgeCue::kSlope, 3) / near, 8);
}

// An overexposed background makes the whole part seem smaller: on however many edges, that does not average out.
TEST_F(CueTest, WhatClippingMovesIsTheWholeOutline) {
  for (const double distance_m : {1.0, 3.0}) {
    const CylinderPose pose{{0, 0, distance_m}, Eigen::Vector3d(0.1, -1, 0.3).normalized()};
    auto points = points_of(pose);
    for (EdgePoint& point : points) point.position_px += CommonEdgeSigma{}.by_clipped_px * point.inward;
    const auto smaller = refine(camera, part, pose, points, {});
    ASSERT_TRUE(smaller);
    const double farther_m = smaller->pose.center_in_cam.z() - distance_m;
    EXPECT_NEAR(depth_sigma(EdgeCue::kClipped, distance_m) / farther_m, 1, 0.25) << distance_m;
  }
}

TEST_F(RefineTest, EdgesThatLittleTellsPullLittle) {
  const CylinderPose pose{{0, 0, 2}, Eigen::Vector3d(0.1, -1, 0.3).normalized()};
  IdealEdges how;
  how.noise_px = 0.05;
  const auto pulled_by = [&](EdgeCue cue) {
    auto points = points_of(pose, how);
    for (EdgePoint& point : points) {
      if (point.inward.x() < 0.9) continue;
      point.position_px += 0.1 * point.inward;
      point.cue = cue;
    }
    const auto refined = refine(camera, part, pose, points, {});
    return refined ? (refined->pose.center_in_cam - pose.center_in_cam).norm() : 0.0;
  };
  const double by_share = pulled_by(EdgeCue::kShare);
  ASSERT_GT(by_share, 0);
  EXPECT_LT(pulled_by(EdgeCue::kNone), 0.7 * by_share);
}

// What moves half a side turns it: the covariance must allow for that as for a shift of all of it.
TEST_F(RefineTest, CovarianceCoversAShiftOfHalfASide) {
  const CylinderPose pose{{0, 0, 2}, Eigen::Vector3d(0.1, -1, 0.3).normalized()};
  const Eigen::Vector2d middle = ideal_pixel(camera, pose.center_in_cam);
  IdealEdges how;
  how.noise_px = 0.02;
  auto points = points_of(pose, how);
  for (EdgePoint& point : points) {
    if (point.inward.x() > 0.9 && point.position_px.y() < middle.y()) point.position_px += 0.05 * point.inward;
  }
  const auto refined = refine(camera, part, pose, points, {});
  ASSERT_TRUE(refined);
  const Eigen::Vector3d center_error = refined->pose.center_in_cam - pose.center_in_cam;
  const Eigen::Vector3d turn = pose.axis_in_cam.cross(refined->pose.axis_in_cam);
  Eigen::Matrix<double, 6, 1> error;
  error << center_error, turn;
  EXPECT_GT(turn.norm(), 1e-4);
  EXPECT_LT(error.dot(refined->covariance.ldlt().solve(error)), 5);  // one of five standard deviations
}

TEST_F(RefineTest, CovarianceIsSymmetricAndPositive) {
  const CylinderPose pose{{0.1, 0, 2}, Eigen::Vector3d(0.5, -1, 0.3).normalized()};
  const auto refined = refine(camera, part, pose, points_of(pose), {});
  ASSERT_TRUE(refined);
  EXPECT_LT((refined->covariance - refined->covariance.transpose()).norm(), 1e-9);
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, 6, 6>> eigen(refined->covariance);
  EXPECT_GT(eigen.eigenvalues()[0], 0);
  EXPECT_NEAR(eigen.eigenvalues()[5], kUnobservableRoll, 1e-6);
}

TEST_F(RefineTest, TooFewPointsGiveNone) {
  const CylinderPose pose{{0, 0, 2}, -Eigen::Vector3d::UnitY()};
  auto points = points_of(pose);
  points.resize(kMinSupport - 1);
  EXPECT_FALSE(refine(camera, part, pose, points, {}));
  EXPECT_FALSE(refine(camera, part, {{0, 0, -2}, Eigen::Vector3d::UnitY()}, points_of(pose), {}));
}

}  // namespace
}  // namespace cylpose
