#include "consistency.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <cylpose/error.hpp>
#include <random>

#include "pose_difference.hpp"

namespace cylpose::bench {
namespace {

// Tables of the distribution.
TEST(ChiSquared, QuantilesAreThoseOfTheTables) {
  EXPECT_NEAR(chi_squared_quantile(0.95, 1), 3.841, 0.001);
  EXPECT_NEAR(chi_squared_quantile(0.5, 5), 4.351, 0.001);
  EXPECT_NEAR(chi_squared_quantile(0.95, 5), 11.070, 0.001);
  EXPECT_NEAR(chi_squared_quantile(0.025, 5), 0.831, 0.001);
  EXPECT_NEAR(chi_squared_quantile(0.975, 100), 129.561, 0.001);
  // Wilson and Hilferty's approximation is good to 1e-4 there.
  const double z = 1.959964;
  const auto approximate = [](double n, double deviate) {
    return n * std::pow(1 - 2 / (9 * n) + deviate * std::sqrt(2 / (9 * n)), 3);
  };
  EXPECT_NEAR(chi_squared_quantile(0.975, 5000) / approximate(5000, z), 1, 1e-4);
  EXPECT_NEAR(chi_squared_quantile(0.025, 5000) / approximate(5000, -z), 1, 1e-4);
  EXPECT_THROW((void)chi_squared_quantile(1, 5), Error);
  EXPECT_THROW((void)chi_squared_quantile(std::nan(""), 5), Error);
  EXPECT_THROW((void)chi_squared_quantile(0.5, 0), Error);
}

TEST(ChiSquared, BandNarrowsAroundTheMean) {
  EXPECT_NEAR(mean_nees_band(1).low, 0.831, 0.001);
  EXPECT_NEAR(mean_nees_band(1).high, 12.833, 0.001);
  const Band band = mean_nees_band(1000);
  EXPECT_NEAR(band.low, 5 - 1.96 * std::sqrt(10.0 / 1000), 0.01);
  EXPECT_NEAR(band.high, 5 + 1.96 * std::sqrt(10.0 / 1000), 0.01);
  EXPECT_TRUE(band.holds(5));
  EXPECT_FALSE(band.holds(5.3));
  EXPECT_FALSE(band.holds(std::nan("")));
  EXPECT_THROW((void)mean_nees_band(0), Error);
}

Matrix5d some_covariance() {
  Matrix5d root = Matrix5d::Zero();
  root.diagonal() << 1e-4, 2e-4, 3e-3, 2e-3, 5e-3;
  root(2, 3) = 1e-3;
  root(4, 0) = 2e-3;
  return root * root.transpose();
}

// An estimate of `truth`, off by a draw of `covariance` and stating `stated` times it.
PoseEstimate drawn(const CylinderPose& truth, const Matrix5d& covariance, double stated, std::mt19937& random) {
  std::normal_distribution<double> normal(0, 1);
  Vector5d deviates;
  for (double& deviate : deviates) deviate = normal(random);
  PoseEstimate estimate;
  estimate.status = PoseStatus::kOk;
  const Matrix5d root = covariance.llt().matrixL();
  estimate.pose = moved(truth, root * deviates);
  const TangentBasis basis(estimate.pose.axis_in_cam);
  Eigen::Matrix<double, 6, 5> to_full = Eigen::Matrix<double, 6, 5>::Zero();
  to_full.topLeftCorner<3, 3>().setIdentity();
  to_full.block<3, 1>(3, 3) = basis.first;
  to_full.block<3, 1>(3, 4) = basis.second;
  estimate.covariance = stated * to_full * covariance * to_full.transpose();
  const Eigen::Vector3d& axis = estimate.pose.axis_in_cam;
  estimate.covariance.bottomRightCorner<3, 3>() += kUnobservableRoll * axis * axis.transpose();
  estimate.pose = with_fixed_sign(estimate.pose);
  return estimate;
}

double mean_nees(double stated, int count) {
  const CylinderPose truth{{0.1, -0.2, 2}, Eigen::Vector3d(0.2, -0.7, 0.5).normalized()};
  std::mt19937 random(7);
  double sum = 0;
  for (int i = 0; i < count; ++i) sum += nees(drawn(truth, some_covariance(), stated, random), truth);
  return sum / count;
}

TEST(Nees, IsInItsBandForHonestCovariancesOnly) {
  constexpr int kCount = 2000;
  const Band band = mean_nees_band(kCount);
  EXPECT_TRUE(band.holds(mean_nees(1, kCount)));
  EXPECT_GT(mean_nees(0.8, kCount), band.high);
  EXPECT_LT(mean_nees(1.2, kCount), band.low);
}

TEST(Nees, DoesNotSeeRollAndSignOfTheAxis) {
  std::mt19937 random(1);
  const CylinderPose truth{{0.1, -0.2, 2}, Eigen::Vector3d(0.2, -0.7, 0.5).normalized()};
  PoseEstimate estimate = drawn(truth, some_covariance(), 1, random);
  const double once = nees(estimate, truth);
  EXPECT_NEAR(nees(estimate, {truth.center_in_cam, -truth.axis_in_cam}), once, 1e-9);
  estimate.covariance.bottomRightCorner<3, 3>() +=
      100 * estimate.pose.axis_in_cam * estimate.pose.axis_in_cam.transpose();
  EXPECT_NEAR(nees(estimate, truth), once, 1e-6 * once);
}

TEST(Nees, RefusesWhatIsNoEstimate) {
  PoseEstimate estimate;
  EXPECT_THROW((void)nees(estimate, {}), Error);
  estimate.status = PoseStatus::kOk;  // with a covariance of zero
  EXPECT_TRUE(std::isinf(nees(estimate, {})));
}

TEST(PoseDifference, UndoesAMove) {
  const CylinderPose from{{0.1, -0.2, 2}, Eigen::Vector3d(0.2, -0.7, 0.5).normalized()};
  const Vector5d move = (Vector5d() << 0.01, -0.02, 0.03, 0.2, -0.4).finished();
  EXPECT_LT((difference(from, moved(from, move)) - move).norm(), 1e-12);
  CylinderPose turned = moved(from, move);
  turned.axis_in_cam = -turned.axis_in_cam;
  EXPECT_LT((difference(from, turned) - move).norm(), 1e-12);
  EXPECT_EQ(difference(from, from).norm(), 0);
}

}  // namespace
}  // namespace cylpose::bench
