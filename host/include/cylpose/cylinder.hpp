// The geometry of a right circular cylinder before a pinhole camera. Camera optical frame, metres, radians; image
// points as normalised rays x = (u, v, 1) unless called pixels. Formulas: docs/algorithm.md, "Geometry".
#pragma once

#include <Eigen/Core>
#include <array>
#include <cylpose/camera.hpp>
#include <optional>
#include <vector>

namespace cylpose {

/// Where a cylinder is. Five degrees of freedom: the roll about the axis cannot be observed, and the sign of the axis
/// is a convention (with_fixed_sign).
struct CylinderPose {
  Eigen::Vector3d center_in_cam = Eigen::Vector3d::Zero();  ///< middle of the two base centres, metres
  Eigen::Vector3d axis_in_cam = Eigen::Vector3d::UnitZ();   ///< unit vector
};

/// The same pose with the axis turned so that ay < 0, or ay = 0 and ax > 0, or ay = ax = 0 and az > 0.
[[nodiscard]] CylinderPose with_fixed_sign(CylinderPose pose);

/// A 3-D line: all points point_in_cam + t * direction_in_cam.
struct AxisLine {
  Eigen::Vector3d point_in_cam;      ///< the point of the line nearest to the camera, metres
  Eigen::Vector3d direction_in_cam;  ///< unit vector
};

/// The axis of the cylinder of radius `radius_m` whose two sides lie in the planes through the camera centre with the
/// unit normals `n1` and `n2`, each oriented so that the axis is on its positive side: d = n1 x n2 / |n1 x n2|, C0 = r
/// (n1 + n2) / (1 + n1.n2). Exact (docs/algorithm.md). None when the planes (nearly) coincide or the axis would pass
/// through the camera.
[[nodiscard]] std::optional<AxisLine> axis_from_sides(const Eigen::Vector3d& n1, const Eigen::Vector3d& n2,
                                                      double radius_m);

/// Unit normals of the two planes through the camera centre that touch the infinite cylinder, oriented so that the axis
/// is on their positive side. None when the camera is inside the infinite cylinder.
[[nodiscard]] std::optional<std::array<Eigen::Vector3d, 2>> side_planes(const CylinderPose& pose, double radius_m);

/// The conic x^T A x = 0 to which the base circle with centre `base_center` and unit normal `axis` projects:
/// A = (B.d)^2 I - (B.d)(B d^T + d B^T) + (B.B - r^2) d d^T.
[[nodiscard]] Eigen::Matrix3d base_conic(const Eigen::Vector3d& base_center, const Eigen::Vector3d& axis,
                                         double radius_m);

/// The two arcs of the base circles that bound the solid's silhouette. The point of base `b` at the angle a is
/// centers[b] + r (cos a toward + sin a across); the arc runs from start[b] over span[b] (radians, signed). Going
/// through arc 0 and then arc 1 is going once around the silhouette; the sides join the end of one to the start of the
/// other.
struct OutlineArcs {
  Eigen::Vector3d toward;  ///< unit vector from the camera to the axis, perpendicular to it
  Eigen::Vector3d across;  ///< axis x toward
  std::array<Eigen::Vector3d, 2> centers;
  std::array<double, 2> start;
  std::array<double, 2> span;

  [[nodiscard]] Eigen::Vector3d point(int base, double angle, double radius_m) const;
};

/// None when the camera is inside the infinite cylinder (no side is seen) or part of the solid lies behind the camera.
[[nodiscard]] std::optional<OutlineArcs> outline_arcs(const CylinderPose& pose, double radius_m, double height_m);

/// The visible outline of the cylinder as the solid's silhouette: a closed polygon of rays (u, v, 1),
/// `samples_per_base` points along each base's arc. Empty when the camera is inside the cylinder or part of it lies
/// behind the camera.
[[nodiscard]] std::vector<Eigen::Vector2d> silhouette(const CylinderPose& pose, double radius_m, double height_m,
                                                      int samples_per_base = 64);

/// First hit of the ray t * direction (t > 0) with the solid cylinder.
struct RayHit {
  double t;                       ///< in units of |direction|
  Eigen::Vector3d normal_in_cam;  ///< outward unit normal of the surface
  bool on_base;                   ///< true on a base, false on the side
};
[[nodiscard]] std::optional<RayHit> intersect_ray(const CylinderPose& pose, double radius_m, double height_m,
                                                  const Eigen::Vector3d& direction);

}  // namespace cylpose
