#include "bound.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <cylpose/curved_border.hpp>
#include <cylpose/refine.hpp>
#include <numbers>
#include <random>

#include "host/ideal_edges.hpp"

namespace cylpose::bench {
namespace {

using cylpose::testing::test_camera;
using cylpose::testing::test_part;

constexpr PieceSigmas kTenthOfAPixel = {0.1, 0.1, 0.1, 0.1};

CylinderPose tilted(double distance_m, double tilt_deg) {
  const double tilt = tilt_deg * std::numbers::pi / 180;
  return {{0.02 * distance_m, -0.03 * distance_m, distance_m},
          Eigen::Vector3d(0.3 * std::sin(tilt), -std::sin(tilt), std::cos(tilt)).normalized()};
}

double degrees(double radians) {
  return radians * 180 / std::numbers::pi;
}

Matrix5d bound_of(const CylinderPose& pose) {
  const auto samples = contour_samples(test_camera(), test_part(), pose);
  return pose_bound(test_camera(), test_part(), pose, samples, kTenthOfAPixel).value();
}

// Values worked out for the design by other means: edge noise of 0.1 px, one sample per contour pixel.
TEST(Bound, HasTheKnownValuesForAnUprightCylinder) {
  const auto sigma = [](double distance_m) {
    const Matrix5d bound = bound_of({{0, 0, distance_m}, -Eigen::Vector3d::UnitY()});
    return std::pair(std::sqrt(bound(2, 2)), degrees(std::sqrt(bound.bottomRightCorner<2, 2>().trace())));
  };
  EXPECT_NEAR(sigma(5).first, 1.3e-3, 0.15e-3);
  EXPECT_NEAR(sigma(3).first, 0.36e-3, 0.04e-3);
  EXPECT_NEAR(sigma(1).first, 0.022e-3, 0.003e-3);
  EXPECT_NEAR(sigma(5).second, 0.3, 0.06);
  EXPECT_NEAR(sigma(1).second, 0.018, 0.004);
}

// The distances of the same places from the outline of a pose a little aside, against the derivative's.
TEST(Bound, InformationIsThatOfFiniteDifferences) {
  for (const double tilt_deg : {85, 50, 35}) {
    const CylinderPose pose = tilted(1.2, tilt_deg);
    const auto samples = contour_samples(test_camera(), test_part(), pose);
    ASSERT_GT(samples.size(), 100U);
    Matrix5d information = Matrix5d::Zero();
    const Vector5d steps = (Vector5d() << 2e-4, 2e-4, 2e-3, 1e-3, 1e-3).finished();
    for (const ContourSample& sample : samples) {
      Vector5d change;
      bool on_outline = true;
      for (int k = 0; k < 5; ++k) {
        double distance[2];
        for (const int side : {0, 1}) {
          const Vector5d move = Vector5d::Unit(k) * steps[k] * (side == 0 ? -1 : 1);
          const auto outline = Outline::of(test_camera(), test_part(), moved(pose, move));
          const auto match = outline->match({sample.position_px, sample.inward}, 3);
          on_outline = on_outline && match && match->piece == sample.piece;
          distance[side] = match ? match->distance_px : 0;
        }
        change[k] = (distance[1] - distance[0]) / (2 * steps[k]);
      }
      // Beside a corner the nearest place is another piece's, or the corner.
      if (on_outline) information += sample.edge_pixels / 0.01 * change * change.transpose();
    }
    const double prior = test_part().height_m / 2;
    information.topLeftCorner<3, 3>() += pose.axis_in_cam * pose.axis_in_cam.transpose() / (prior * prior);
    const Matrix5d bound = bound_of(pose);
    const Matrix5d by_differences = information.inverse();
    for (int k = 0; k < 5; ++k) {
      EXPECT_NEAR(std::sqrt(by_differences(k, k)) / std::sqrt(bound(k, k)), 1, 0.06) << tilt_deg << " deg, " << k;
    }
  }
}

// A thousand refinements from noisy places on the outline scatter as the bound says: not less, and hardly more, as the
// robust weights cost 5 %.
TEST(Bound, IsReachedByTheRefinement) {
  const CylinderPose pose = tilted(1.5, 60);
  const auto samples = contour_samples(test_camera(), test_part(), pose);
  std::vector<EdgePoint> clean;
  double pixels = 0;
  for (const ContourSample& sample : samples) {
    const double shift_px = inward_shift_px(sample.curvature);
    clean.push_back({sample.position_px + shift_px * sample.inward, sample.inward, EdgeCue::kShare});
    pixels += sample.edge_pixels;
  }
  // One point each, where the bound counts some three.
  const double per_point = pixels / static_cast<double>(samples.size());
  constexpr double kNoise = 0.1;
  std::mt19937 random(5);
  std::normal_distribution<double> noise(0, kNoise);
  constexpr int kRuns = 1000;
  Matrix5d covariance = Matrix5d::Zero();
  for (int run = 0; run < kRuns; ++run) {
    std::vector<EdgePoint> points = clean;
    for (EdgePoint& point : points) point.position_px += noise(random) * point.inward;
    const auto refined = refine(test_camera(), test_part(), pose, points, {});
    ASSERT_TRUE(refined);
    const Vector5d error = difference(pose, refined->pose);
    covariance += error * error.transpose() / kRuns;
  }
  PieceSigmas sigmas{};
  sigmas.fill(kNoise * std::sqrt(per_point));
  const Matrix5d bound = pose_bound(test_camera(), test_part(), pose, samples, sigmas).value();
  const double volume = std::pow(covariance.determinant() / bound.determinant(), 0.1);  // a mean ratio of sigmas
  EXPECT_GT(volume, 0.95);
  EXPECT_LT(volume, 1.1);
}

TEST(Bound, HiddenPiecesTellNothing) {
  const CylinderPose pose{{0, 0, 2}, -Eigen::Vector3d::UnitY()};
  const double middle = test_camera().cy;
  const auto sides_only = [&](const Eigen::Vector2d& p) { return std::abs(p.y() - middle) < 60; };
  const auto all = contour_samples(test_camera(), test_part(), pose);
  const auto some = contour_samples(test_camera(), test_part(), pose, sides_only);
  ASSERT_LT(some.size(), all.size());
  for (const ContourSample& sample : some) EXPECT_TRUE(sample.piece == kSide0 || sample.piece == kSide1);
  const Matrix5d bound = pose_bound(test_camera(), test_part(), pose, some, kTenthOfAPixel).value();
  EXPECT_NEAR(std::sqrt(bound(1, 1)), test_part().height_m / 2, 0.01)
      << "only the prior knows the place along the axis";
  EXPECT_GT(bound(2, 2), 2 * bound_of(pose)(2, 2));
  EXPECT_FALSE(pose_bound(test_camera(), test_part(), pose, {}, kTenthOfAPixel));
}

TEST(Bound, CountsOneSamplePerPixelOfTheContour) {
  double pixels = 0;
  for (const ContourSample& sample :
       contour_samples(test_camera(), test_part(), {{0, 0, 2}, -Eigen::Vector3d::UnitY()})) {
    pixels += sample.edge_pixels;
  }
  // Two sides of 0.4 m and two bases 0.1 m wide, hardly curved.
  EXPECT_NEAR(pixels, 2 * (0.4 + 0.1) * 1215 / 2, 0.03 * 607);
}

TEST(Scatter, IsThatOfThePointsWithoutTheirBias) {
  const CylinderPose pose = tilted(1.2, 70);
  const auto outline = Outline::of(test_camera(), test_part(), pose);
  std::mt19937 random(3);
  std::normal_distribution<double> noise(0, 1);
  std::vector<EdgePoint> points;
  for (const ContourSample& sample : contour_samples(test_camera(), test_part(), pose)) {
    const bool side = sample.piece == kSide0 || sample.piece == kSide1;
    for (int i = 0; i < 20; ++i) {
      const double away = side ? 0.4 + 0.05 * noise(random) : -0.2 + 0.15 * noise(random);
      points.push_back({sample.position_px + away * sample.inward, sample.inward});
    }
  }
  const auto sigmas = edge_scatter(*outline, points);
  ASSERT_TRUE(sigmas);
  EXPECT_NEAR((*sigmas)[kSide0], 0.05, 0.004);
  EXPECT_NEAR((*sigmas)[kSide1], 0.05, 0.004);
  EXPECT_NEAR((*sigmas)[kBase0], 0.15, 0.02);
  EXPECT_NEAR((*sigmas)[kBase1], 0.15, 0.02);
  EXPECT_FALSE(edge_scatter(*outline, {}));
}

}  // namespace
}  // namespace cylpose::bench
