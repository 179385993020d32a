#include "motion_filter.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <cmath>
#include <cylpose/pose.hpp>

namespace cylpose {
namespace {

Eigen::Quaterniond rotation_of(const Eigen::Vector2d& rotation) {
  const double angle = rotation.norm();
  if (angle == 0) return Eigen::Quaterniond::Identity();
  const Eigen::Vector2d about = rotation / angle;
  return Eigen::Quaterniond(Eigen::AngleAxisd(angle, Eigen::Vector3d(about.x(), about.y(), 0)));
}

// From centre and rotations in the frame to centre and rotations in the camera.
Eigen::Matrix<double, 6, 5> cam_from_frame(const Eigen::Quaterniond& frame) {
  Eigen::Matrix<double, 6, 5> map = Eigen::Matrix<double, 6, 5>::Zero();
  map.topLeftCorner<3, 3>().setIdentity();
  map.bottomRightCorner<3, 2>() = frame.toRotationMatrix().leftCols<2>();
  return map;
}

// What grows in `seconds` from an error of the state at a constant velocity. On the sphere great circles converge: of
// two that start side by side the distance goes with the cosine of the arc (Jacobi's equation).
Eigen::Matrix<double, 10, 10> transition(const Eigen::Vector2d& rate, double seconds) {
  Eigen::Matrix<double, 10, 10> map = Eigen::Matrix<double, 10, 10>::Identity();
  map.topRightCorner<5, 5>() = seconds * Eigen::Matrix<double, 5, 5>::Identity();
  const double speed = rate.norm();
  const double arc = speed * seconds;
  if (arc == 0) return map;
  const Eigen::Vector2d sideways = Eigen::Vector2d(-rate.y(), rate.x()) / speed;
  const Eigen::Matrix2d on_sideways = sideways * sideways.transpose();
  map.block<2, 2>(3, 3) += (std::cos(arc) - 1) * on_sideways;
  map.block<2, 2>(3, 8) += (std::sin(arc) / speed - seconds) * on_sideways;
  map.block<2, 2>(8, 3) -= speed * std::sin(arc) * on_sideways;
  map.block<2, 2>(8, 8) += (std::cos(arc) - 1) * on_sideways;
  return map;
}

template <typename Matrix>
double worst_sigma(const Matrix& covariance) {
  const Eigen::SelfAdjointEigenSolver<typename Matrix::PlainObject> eigen(covariance, Eigen::EigenvaluesOnly);
  return std::sqrt(std::max(0.0, eigen.eigenvalues().maxCoeff()));
}

}  // namespace

MotionFilter::MotionFilter(const CylinderPose& pose, const Matrix6d& covariance, const FilterOptions& options)
    : center_(pose.center_in_cam),
      frame_(Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), pose.axis_in_cam)),
      velocity_density_(options.velocity_drift_m_s * options.velocity_drift_m_s),
      rate_density_(options.rate_drift_rad_s * options.rate_drift_rad_s) {
  covariance_.topLeftCorner<5, 5>() = innovation(pose, covariance).covariance;
  covariance_.diagonal().segment<3>(5).setConstant(options.start_speed_m_s * options.start_speed_m_s);
  covariance_.diagonal().segment<2>(8).setConstant(options.start_rate_rad_s * options.start_rate_rad_s);
}

void MotionFilter::predict(double seconds) {
  const Matrix10d map = transition(rate_, seconds);
  covariance_ = map * covariance_ * map.transpose();
  for (Eigen::Index i = 0; i < 5; ++i) {
    const double density = i < 3 ? velocity_density_ : rate_density_;
    covariance_(i, i) += density * seconds * seconds * seconds / 3;
    covariance_(i, i + 5) += density * seconds * seconds / 2;
    covariance_(i + 5, i) += density * seconds * seconds / 2;
    covariance_(i + 5, i + 5) += density * seconds;
  }
  center_ += seconds * velocity_;
  turn(seconds * rate_);
}

double MotionFilter::distance2(const CylinderPose& measured, const Matrix6d& covariance) const {
  const Innovation found = innovation(measured, covariance);
  const Matrix5d expected = covariance_.topLeftCorner<5, 5>() + found.covariance;
  return found.offset.dot(expected.llt().solve(found.offset));
}

void MotionFilter::update(const CylinderPose& measured, const Matrix6d& covariance) {
  const Innovation found = innovation(measured, covariance);
  const Matrix5d expected = covariance_.topLeftCorner<5, 5>() + found.covariance;
  const Eigen::Matrix<double, 10, 5> gain = expected.llt().solve(covariance_.topRows<5>()).transpose();
  const Eigen::Matrix<double, 10, 1> moves = gain * found.offset;
  center_ += moves.head<3>();
  velocity_ += moves.segment<3>(5);
  rate_ += moves.tail<2>();
  turn(moves.segment<2>(3));
  // Joseph's form stays symmetric and positive whatever is rounded.
  Matrix10d kept = Matrix10d::Identity();
  kept.leftCols<5>() -= gain;
  covariance_ = (kept * covariance_ * kept.transpose() + gain * found.covariance * gain.transpose()).eval();
}

Matrix6d MotionFilter::covariance() const {
  const Eigen::Matrix<double, 6, 5> map = cam_from_frame(frame_);
  Matrix6d full = map * covariance_.topLeftCorner<5, 5>() * map.transpose();
  full.bottomRightCorner<3, 3>() += kUnobservableRoll * axis() * axis().transpose();
  return full;
}

double MotionFilter::center_sigma_m() const {
  return worst_sigma(covariance_.topLeftCorner<3, 3>());
}

double MotionFilter::axis_sigma_rad() const {
  return worst_sigma(covariance_.block<2, 2>(3, 3));
}

Eigen::Matrix3d MotionFilter::point_covariance(const Eigen::Vector3d& point) const {
  const Eigen::Matrix3d axes = frame_.toRotationMatrix();
  const Eigen::Vector3d arm = axes * point;
  Eigen::Matrix<double, 3, 5> map;
  map << Eigen::Matrix3d::Identity(), axes.col(0).cross(arm), axes.col(1).cross(arm);
  return map * covariance_.topLeftCorner<5, 5>() * map.transpose();
}

MotionFilter::Innovation MotionFilter::innovation(const CylinderPose& measured, const Matrix6d& covariance) const {
  Eigen::Vector3d axis = frame_.conjugate() * measured.axis_in_cam;
  if (axis.z() < 0) axis = -axis;
  const double sine = axis.head<2>().norm();
  const double angle_per_sine = sine > 0 ? std::atan2(sine, axis.z()) / sine : 1;
  // z x axis: the rotation that takes the predicted axis to the measured one.
  const Eigen::Vector2d rotation = angle_per_sine * Eigen::Vector2d(-axis.y(), axis.x());
  Innovation found;
  found.offset << measured.center_in_cam - center_, rotation;
  const Eigen::Matrix<double, 6, 5> map = cam_from_frame(frame_ * rotation_of(rotation));
  found.covariance = map.transpose() * covariance * map;
  return found;
}

void MotionFilter::turn(const Eigen::Vector2d& rotation) {
  frame_ = (frame_ * rotation_of(rotation)).normalized();
}

}  // namespace cylpose
