#include "pose_difference.hpp"

#include <Eigen/Geometry>
#include <cmath>

namespace cylpose::bench {

Vector5d difference(const CylinderPose& from, const CylinderPose& to) {
  const TangentBasis basis(from.axis_in_cam);
  const double sign = from.axis_in_cam.dot(to.axis_in_cam) < 0 ? -1 : 1;
  const Eigen::Vector3d across = from.axis_in_cam.cross(sign * to.axis_in_cam);
  const double sine = across.norm();
  const double angle = std::atan2(sine, std::abs(from.axis_in_cam.dot(to.axis_in_cam)));
  const Eigen::Vector3d rotation = sine > 0 ? Eigen::Vector3d(angle / sine * across) : Eigen::Vector3d::Zero();
  Vector5d move;
  move << to.center_in_cam - from.center_in_cam, rotation.dot(basis.first), rotation.dot(basis.second);
  return move;
}

CylinderPose moved(const CylinderPose& from, const Vector5d& move) {
  const TangentBasis basis(from.axis_in_cam);
  const Eigen::Vector3d rotation = move[3] * basis.first + move[4] * basis.second;
  const double angle = rotation.norm();
  CylinderPose to{from.center_in_cam + move.head<3>(), from.axis_in_cam};
  if (angle > 0) to.axis_in_cam = Eigen::AngleAxisd(angle, rotation / angle) * from.axis_in_cam;
  return to;
}

Matrix5d covariance_in_basis(const PoseEstimate& estimate) {
  const TangentBasis basis(estimate.pose.axis_in_cam);
  Eigen::Matrix<double, 6, 5> to_full = Eigen::Matrix<double, 6, 5>::Zero();
  to_full.topLeftCorner<3, 3>().setIdentity();
  to_full.block<3, 1>(3, 3) = basis.first;
  to_full.block<3, 1>(3, 4) = basis.second;
  return to_full.transpose() * estimate.covariance * to_full;
}

}  // namespace cylpose::bench
