// Simulated motions of a cylinder and measurements of it, for tests of what filters over time.
#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cylpose/cylinder.hpp>
#include <cylpose/pose.hpp>
#include <random>

namespace cylpose::testing {

/// A cylinder whose velocity and angular velocity across the axis take a random walk.
class MovingCylinder {
 public:
  struct Motion {
    CylinderPose start{{0, 0, 1.5}, Eigen::Vector3d(0.3, -0.8, 0.5).normalized()};
    Eigen::Vector3d velocity = {0.02, -0.01, -0.05};  // m/s
    Eigen::Vector3d rate = {0.1, -0.05, 0.2};         // rad/s; what of it is a roll does nothing
    double velocity_drift = 0;                        // m/s in a second
    double rate_drift = 0;                            // rad/s in a second
  };

  MovingCylinder(const Motion& motion, unsigned seed)
      : motion_(motion), pose_(motion.start), velocity_(motion.velocity), random_(seed) {
    rate_ = across(motion.rate);
  }

  /// Goes on in steps of a millisecond.
  const CylinderPose& advance(double seconds) {
    constexpr double kStep = 1e-3;
    const auto steps = static_cast<int>(std::ceil(seconds / kStep - 1e-9));
    for (int i = 0; i < steps; ++i) step(seconds / steps);
    return pose_;
  }

  [[nodiscard]] const CylinderPose& pose() const { return pose_; }

 private:
  [[nodiscard]] Eigen::Vector3d across(const Eigen::Vector3d& v) const {
    return v - v.dot(pose_.axis_in_cam) * pose_.axis_in_cam;
  }

  Eigen::Vector3d white() { return {unit_(random_), unit_(random_), unit_(random_)}; }

  void step(double seconds) {
    const double root = std::sqrt(seconds);
    velocity_ += motion_.velocity_drift * root * white();
    rate_ += across(motion_.rate_drift * root * white());
    pose_.center_in_cam += seconds * velocity_;
    if (rate_.norm() > 0) {
      pose_.axis_in_cam =
          (Eigen::AngleAxisd(seconds * rate_.norm(), rate_.normalized()) * pose_.axis_in_cam).normalized();
    }
    rate_ = across(rate_);
  }

  Motion motion_;
  CylinderPose pose_;
  Eigen::Vector3d velocity_;
  Eigen::Vector3d rate_;
  std::mt19937 random_;
  std::normal_distribution<double> unit_{0, 1};
};

/// The two directions across the axis, as the columns of the rotations that turn it.
inline Eigen::Matrix<double, 3, 2> rotations_across(const Eigen::Vector3d& axis) {
  Eigen::Matrix<double, 3, 2> basis;
  basis << axis.unitOrthogonal(), axis.cross(axis.unitOrthogonal());
  return basis;
}

/// Measures with errors as the camera makes them, depth and tilt worst and correlated, and states their covariance.
class Measuring {
 public:
  explicit Measuring(unsigned seed, double scale = 1) : random_(seed), scale_(scale) {}

  /// With the sign of the fixed rule.
  PoseEstimate operator()(const CylinderPose& truth) {
    const Eigen::Matrix<double, 3, 2> basis = rotations_across(truth.axis_in_cam);
    Eigen::Matrix<double, 6, 5> root = Eigen::Matrix<double, 6, 5>::Zero();
    root.diagonal() << 0.0005, 0.0005, 0.004, 0, 0;
    root.block<3, 2>(3, 3) = 0.01 * basis;
    root(3, 2) = 0.006;  // tilts with depth
    // Across the axis only: nothing is measured of the roll.
    root.bottomRows<3>() = (basis * basis.transpose() * root.bottomRows<3>()).eval();
    root *= scale_;
    Eigen::Matrix<double, 5, 1> draw;
    for (double& value : draw) value = unit_(random_);
    const Eigen::Matrix<double, 6, 1> error = root * draw;
    const Eigen::Vector3d turn = error.tail<3>();

    PoseEstimate estimate;
    estimate.status = PoseStatus::kOk;
    estimate.pose.center_in_cam = truth.center_in_cam + error.head<3>();
    // The roll is about the axis as measured: so is what lies across it.
    const Eigen::Matrix3d turned = Eigen::AngleAxisd(turn.norm(), turn.stableNormalized()).toRotationMatrix();
    const Eigen::Vector3d axis = (turned * truth.axis_in_cam).normalized();
    estimate.pose.axis_in_cam = axis;
    estimate.pose = with_fixed_sign(estimate.pose);
    root.bottomRows<3>() = (turned * root.bottomRows<3>()).eval();
    estimate.covariance = root * root.transpose();
    estimate.covariance.bottomRightCorner<3, 3>() += kUnobservableRoll * axis * axis.transpose();
    estimate.rms_px = 0.2;
    estimate.support = 500;
    estimate.seen = 0.9;
    return estimate;
  }

 private:
  std::mt19937 random_;
  std::normal_distribution<double> unit_{0, 1};
  double scale_;
};

/// Normalised estimation error squared: chi-square with 5 degrees of freedom when the covariance is honest.
inline double normalised_error(const PoseEstimate& estimate, const CylinderPose& truth) {
  const Eigen::Vector3d& axis = estimate.pose.axis_in_cam;
  const Eigen::Vector3d true_axis = truth.axis_in_cam.dot(axis) < 0 ? -truth.axis_in_cam : truth.axis_in_cam;
  Eigen::Matrix<double, 6, 5> observable = Eigen::Matrix<double, 6, 5>::Zero();
  observable.topLeftCorner<3, 3>().setIdentity();
  observable.bottomRightCorner<3, 2>() = rotations_across(axis);
  const Eigen::Vector3d turn = axis.cross(true_axis).stableNormalized() * std::acos(std::min(1.0, axis.dot(true_axis)));
  Eigen::Matrix<double, 6, 1> error;
  error << truth.center_in_cam - estimate.pose.center_in_cam, turn;
  const Eigen::Matrix<double, 5, 1> seen = observable.transpose() * error;
  const Eigen::Matrix<double, 5, 5> covariance = observable.transpose() * estimate.covariance * observable;
  return seen.dot(covariance.llt().solve(seen));
}

}  // namespace cylpose::testing
