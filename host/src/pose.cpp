#include <Eigen/Eigenvalues>
#include <cmath>
#include <cylpose/pose.hpp>

namespace cylpose {

std::string_view to_string(PoseStatus status) {
  switch (status) {
    case PoseStatus::kOk:
      return "ok";
    case PoseStatus::kPredicted:
      return "predicted";
    case PoseStatus::kNone:
      return "none";
  }
  return "none";
}

double PoseEstimate::sigma_axis_rad() const {
  // A rotation w moves the axis d by w x d: covariance [d]x W [d]x^T, of rank 2 across d; the roll drops out.
  const Eigen::Vector3d& d = pose.axis_in_cam;
  Eigen::Matrix3d cross;
  cross << 0, -d.z(), d.y(), d.z(), 0, -d.x(), -d.y(), d.x(), 0;
  const Eigen::Matrix3d axis_covariance = cross * covariance.bottomRightCorner<3, 3>() * cross.transpose();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(axis_covariance, Eigen::EigenvaluesOnly);
  return std::sqrt(std::max(0.0, eigen.eigenvalues().z()));
}

}  // namespace cylpose
