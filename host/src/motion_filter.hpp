// Constant-velocity error-state Kalman filter of one cylinder.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cylpose/cylinder.hpp>
#include <cylpose/pose_filter.hpp>

namespace cylpose {

using Matrix6d = Eigen::Matrix<double, 6, 6>;

/// The axis lives on the unit sphere. A frame of axes goes with it, z along the axis, that never rolls about it
/// (parallel transport), so the two coordinates across the axis mean the same before and after a motion and no
/// direction of the axis is special. State: centre, frame, velocity, angular velocity across the axis (constant: the
/// axis moves on a great circle). Errors, in this order: centre 3 (m), rotation about the frame's x and y (rad),
/// velocity 3, angular velocity about x and y. Covariances are 6x6 as PoseEstimate::covariance; what they say about the
/// roll is ignored.
class MotionFilter {
 public:
  /// At rest, give or take the start speeds of `options`.
  MotionFilter(const CylinderPose& pose, const Matrix6d& covariance, const FilterOptions& options);

  void predict(double seconds);

  /// Squared Mahalanobis distance of a measured pose, axis up to its sign: chi-square with 5 degrees of freedom for
  /// right ones.
  [[nodiscard]] double distance2(const CylinderPose& measured, const Matrix6d& covariance) const;

  void update(const CylinderPose& measured, const Matrix6d& covariance);

  [[nodiscard]] CylinderPose pose() const { return {center_, axis()}; }
  [[nodiscard]] Matrix6d covariance() const;

  [[nodiscard]] double center_sigma_m() const;  ///< in the worst direction
  [[nodiscard]] double axis_sigma_rad() const;  ///< in the worst direction

  /// A point fixed to the cylinder, given in the frame that goes with the axis, its origin in the centre; and what the
  /// pose's covariance does to it (m^2).
  [[nodiscard]] Eigen::Vector3d point_in_cam(const Eigen::Vector3d& point) const { return center_ + frame_ * point; }
  [[nodiscard]] Eigen::Matrix3d point_covariance(const Eigen::Vector3d& point) const;

 private:
  using Vector5d = Eigen::Matrix<double, 5, 1>;
  using Matrix5d = Eigen::Matrix<double, 5, 5>;
  using Matrix10d = Eigen::Matrix<double, 10, 10>;

  struct Innovation {
    Vector5d offset;      // measured - predicted
    Matrix5d covariance;  // of the measurement, in the frame of the prediction
  };
  [[nodiscard]] Innovation innovation(const CylinderPose& measured, const Matrix6d& covariance) const;

  [[nodiscard]] Eigen::Vector3d axis() const { return frame_ * Eigen::Vector3d::UnitZ(); }
  void turn(const Eigen::Vector2d& rotation);

  Eigen::Vector3d center_;
  Eigen::Quaterniond frame_;  // camera from the axis's frame
  Eigen::Vector3d velocity_ = Eigen::Vector3d::Zero();
  Eigen::Vector2d rate_ = Eigen::Vector2d::Zero();
  Matrix10d covariance_ = Matrix10d::Zero();
  double velocity_density_;  // m^2/s^3
  double rate_density_;      // rad^2/s^3
};

}  // namespace cylpose
