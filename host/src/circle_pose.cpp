#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <cylpose/circle_pose.hpp>

namespace cylpose {

Eigen::Matrix3d conic_of_rays(const CameraModel& camera, const Ellipse& ellipse) {
  Eigen::Matrix3d pixel_of_ray;
  pixel_of_ray << camera.fx, 0, camera.cx,  //
      0, camera.fy, camera.cy,              //
      0, 0, 1;
  return pixel_of_ray.transpose() * ellipse.conic() * pixel_of_ray;
}

std::optional<std::array<CirclePose, 2>> circle_poses(const Eigen::Matrix3d& conic, double radius_m) {
  if (!conic.allFinite()) return std::nullopt;
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(conic);
  // Two eigenvalues have one sign, the third the other; here two are positive.
  const bool flip = eigen.eigenvalues()[1] < 0;
  const Eigen::Vector3d values = flip ? Eigen::Vector3d(-eigen.eigenvalues().reverse()) : eigen.eigenvalues();
  const double l1 = values[2];
  const double l2 = values[1];
  const double l3 = values[0];
  if (!(l2 > 0 && l3 < 0)) return std::nullopt;
  const Eigen::Vector3d e1 = eigen.eigenvectors().col(flip ? 0 : 2);
  Eigen::Vector3d e3 = eigen.eigenvectors().col(flip ? 2 : 0);
  if (e3.z() < 0) e3 = -e3;

  const double sine = std::sqrt(std::max(0.0, (l1 - l2) / (l1 - l3)));
  const double cosine = std::sqrt(std::max(0.0, (l2 - l3) / (l1 - l3)));
  const double scale = radius_m / std::sqrt(-l1 * l3);
  std::array<CirclePose, 2> poses;
  for (const std::size_t i : {0U, 1U}) {
    const double side = i == 0 ? 1 : -1;
    poses[i].normal_in_cam = (side * sine * e1 - cosine * e3).normalized();
    poses[i].center_in_cam = scale * (cosine * l1 * e3 - side * sine * l3 * e1);
    if (poses[i].center_in_cam.z() <= 0) return std::nullopt;
  }
  return poses;
}

}  // namespace cylpose
