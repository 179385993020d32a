// Where is the circle that an ellipse is the image of?
#pragma once

#include <Eigen/Core>
#include <array>
#include <cylpose/camera.hpp>
#include <cylpose/ellipse.hpp>
#include <optional>

namespace cylpose {

/// A circle of known radius before the camera, metres, camera frame.
struct CirclePose {
  Eigen::Vector3d center_in_cam;
  Eigen::Vector3d normal_in_cam;  ///< unit vector, toward the camera: normal . center < 0
};

/// The conic x^T A x = 0 of the rays x = (u, v, 1) that belongs to an ellipse in pixels of the ideal camera:
/// A = K^T C K.
[[nodiscard]] Eigen::Matrix3d conic_of_rays(const CameraModel& camera, const Ellipse& ellipse);

/// The two circles of radius `radius_m` whose image is the conic x^T A x = 0 (of rays, any scale and sign): the plane
/// sections of an elliptic cone that are circles (Kanatani and Liu 1993; Chen, Wu and Wada 2004). With the eigenvalues
/// l1 >= l2 > 0 > l3 of A and unit eigenvectors e1, e3,
///   normal = +-g e1 - h e3, centre = r (l1 h e3 -+ l3 g e1) / sqrt(-l1 l3), e3 away from the camera,
/// where g^2 = (l1 - l2) / (l1 - l3) and h^2 = (l2 - l3) / (l1 - l3).
/// They are one and the same where the circle is seen face-on (l1 = l2); near there the normal has half as many valid
/// digits as the conic, since the tilt goes with the root of l1 - l2. None when the conic is no ellipse's.
[[nodiscard]] std::optional<std::array<CirclePose, 2>> circle_poses(const Eigen::Matrix3d& conic, double radius_m);

}  // namespace cylpose
