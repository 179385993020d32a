#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cylpose/circle_pose.hpp>
#include <cylpose/cylinder.hpp>
#include <limits>
#include <numbers>
#include <random>

#include "ideal_edges.hpp"

namespace cylpose {
namespace {

constexpr double kRadius = 0.05;

// A circle whose normal is `tilt` radians off the line of sight to its centre.
CirclePose tilted(const Eigen::Vector3d& center, double tilt, double turn) {
  const Eigen::Vector3d toward_camera = -center.normalized();
  const Eigen::Vector3d across = Eigen::AngleAxisd(turn, toward_camera) * toward_camera.unitOrthogonal();
  return {center, Eigen::AngleAxisd(tilt, across) * toward_camera};
}

double error_of(const CirclePose& pose, const CirclePose& truth) {
  return std::max((pose.center_in_cam - truth.center_in_cam).norm(), (pose.normal_in_cam - truth.normal_in_cam).norm());
}

TEST(CirclePoses, OneOfTheTwoIsTheCircle) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> unit(-1, 1);
  for (int i = 0; i < 2000; ++i) {
    const Eigen::Vector3d center(unit(random), 0.5 * unit(random), 2.5 + 2 * unit(random));
    const double tilt = 0.75 + 0.7 * unit(random);
    const CirclePose truth = tilted(center, tilt, 3 * unit(random));
    const double scale = std::exp(5 * unit(random)) * (i % 2 == 0 ? 1 : -1);
    const auto poses = circle_poses(scale * base_conic(center, truth.normal_in_cam, kRadius), kRadius);
    ASSERT_TRUE(poses) << i;
    EXPECT_LT(std::min(error_of((*poses)[0], truth), error_of((*poses)[1], truth)), 1e-9) << i;
    EXPECT_GT(((*poses)[0].normal_in_cam - (*poses)[1].normal_in_cam).norm(), 0.01) << i;
  }
}

TEST(CirclePoses, BothHaveTheConicAsImage) {
  std::mt19937 random(2);
  std::uniform_real_distribution<double> unit(-1, 1);
  for (const double tilt : {1.5, 0.3, 1e-2, 1e-4, 1e-7, 0.0}) {
    for (int i = 0; i < 50; ++i) {
      const Eigen::Vector3d center(unit(random), 0.5 * unit(random), 2.5 + 2 * unit(random));
      const CirclePose truth = tilted(center, tilt, 3 * unit(random));
      const Eigen::Matrix3d conic = base_conic(center, truth.normal_in_cam, kRadius).normalized();
      const auto poses = circle_poses(conic, kRadius);
      ASSERT_TRUE(poses) << tilt;
      for (const CirclePose& pose : *poses) {
        EXPECT_NEAR(pose.normal_in_cam.norm(), 1, 1e-12);
        EXPECT_LT(pose.normal_in_cam.dot(pose.center_in_cam), 0);
        EXPECT_GT(pose.center_in_cam.z(), 0);
        const Eigen::Matrix3d image = base_conic(pose.center_in_cam, pose.normal_in_cam, kRadius).normalized();
        EXPECT_LT((image - conic).norm(), 1e-9) << tilt;
      }
    }
  }
}

TEST(CirclePoses, FaceOnBothAreTheCircle) {
  for (const Eigen::Vector3d& center : {Eigen::Vector3d(0, 0, 1), Eigen::Vector3d(0.5, -0.3, 2)}) {
    const CirclePose truth = tilted(center, 0, 0);
    const auto poses = circle_poses(base_conic(center, truth.normal_in_cam, kRadius), kRadius);
    ASSERT_TRUE(poses);
    for (const CirclePose& pose : *poses) {
      EXPECT_LT((pose.center_in_cam - center).norm(), 1e-9);
      EXPECT_LT((pose.normal_in_cam - truth.normal_in_cam).norm(), 1e-6);  // the root of the rounding
    }
  }
}

TEST(CirclePoses, PixelsAndRaysAgree) {
  const CameraModel camera = testing::test_camera();
  const CirclePose truth = tilted({0.2, -0.1, 1.5}, 0.6, 1);
  const Eigen::Vector3d e1 = truth.normal_in_cam.unitOrthogonal();
  const Eigen::Vector3d e2 = truth.normal_in_cam.cross(e1);
  std::vector<Eigen::Vector2d> pixels;
  for (int i = 0; i < 60; ++i) {
    const double angle = 2 * std::numbers::pi * i / 60;
    pixels.push_back(
        ideal_pixel(camera, truth.center_in_cam + kRadius * (std::cos(angle) * e1 + std::sin(angle) * e2)));
  }
  const auto ellipse = fit_ellipse(pixels);
  ASSERT_TRUE(ellipse);
  const auto poses = circle_poses(conic_of_rays(camera, *ellipse), kRadius);
  ASSERT_TRUE(poses);
  EXPECT_LT(std::min(error_of((*poses)[0], truth), error_of((*poses)[1], truth)), 1e-9);
}

TEST(CirclePoses, NoneForWhatIsNoEllipse) {
  EXPECT_FALSE(circle_poses(Eigen::Matrix3d::Identity(), kRadius));  // no real point
  EXPECT_FALSE(circle_poses(Eigen::Matrix3d::Zero(), kRadius));
  EXPECT_FALSE(circle_poses(Eigen::Vector3d(1, 0, -1).asDiagonal(), kRadius));  // two lines
  EXPECT_FALSE(circle_poses(Eigen::Matrix3d::Constant(std::numeric_limits<double>::quiet_NaN()), kRadius));
}

}  // namespace
}  // namespace cylpose
