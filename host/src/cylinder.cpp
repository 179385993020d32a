#include <Eigen/Geometry>
#include <cmath>
#include <cylpose/cylinder.hpp>
#include <numbers>

namespace cylpose {
namespace {

// sin^2 of the angle between two side planes below which they count as one (the axis is then undefined).
constexpr double kSamePlane = 1e-16;

Eigen::Vector2d to_ray(const Eigen::Vector3d& point) {
  return point.head<2>() / point.z();
}

// Depth of the solid's point nearest to the image plane's side of the camera.
double nearest_depth(const CylinderPose& pose, double radius_m, double height_m) {
  const double slope = pose.axis_in_cam.z();
  return pose.center_in_cam.z() - std::abs(slope) * height_m / 2 -
         radius_m * std::sqrt(std::max(0.0, 1 - slope * slope));
}

}  // namespace

CylinderPose with_fixed_sign(CylinderPose pose) {
  const Eigen::Vector3d& d = pose.axis_in_cam;
  const bool flip = d.y() != 0 ? d.y() > 0 : (d.x() != 0 ? d.x() < 0 : d.z() < 0);
  if (flip) pose.axis_in_cam = -pose.axis_in_cam;
  return pose;
}

std::optional<AxisLine> axis_from_sides(const Eigen::Vector3d& n1, const Eigen::Vector3d& n2, double radius_m) {
  const Eigen::Vector3d along = n1.cross(n2);
  const double one_plus_cosine = 1 + n1.dot(n2);
  if (along.squaredNorm() < kSamePlane || one_plus_cosine <= 0) return std::nullopt;
  return AxisLine{radius_m * (n1 + n2) / one_plus_cosine, along.normalized()};
}

std::optional<std::array<Eigen::Vector3d, 2>> side_planes(const CylinderPose& pose, double radius_m) {
  const Eigen::Vector3d& d = pose.axis_in_cam;
  const Eigen::Vector3d to_axis = pose.center_in_cam - d * d.dot(pose.center_in_cam);
  const double distance = to_axis.norm();
  if (distance <= radius_m) return std::nullopt;
  // A tangent plane's normal is perpendicular to d and at distance r from the axis: n . to_axis = r.
  const Eigen::Vector3d toward = to_axis / distance;
  const Eigen::Vector3d across = d.cross(toward);
  const double cosine = radius_m / distance;
  const double sine = std::sqrt(1 - cosine * cosine);
  return std::array<Eigen::Vector3d, 2>{cosine * toward + sine * across, cosine * toward - sine * across};
}

Eigen::Matrix3d base_conic(const Eigen::Vector3d& base_center, const Eigen::Vector3d& axis, double radius_m) {
  const double height = base_center.dot(axis);
  return height * height * Eigen::Matrix3d::Identity() -
         height * (base_center * axis.transpose() + axis * base_center.transpose()) +
         (base_center.squaredNorm() - radius_m * radius_m) * axis * axis.transpose();
}

Eigen::Vector3d OutlineArcs::point(int base, double angle, double radius_m) const {
  return centers[static_cast<std::size_t>(base)] + radius_m * (std::cos(angle) * toward + std::sin(angle) * across);
}

std::optional<OutlineArcs> outline_arcs(const CylinderPose& pose, double radius_m, double height_m) {
  const Eigen::Vector3d& d = pose.axis_in_cam;
  const Eigen::Vector3d to_axis = pose.center_in_cam - d * d.dot(pose.center_in_cam);
  const double distance = to_axis.norm();
  if (distance <= radius_m || nearest_depth(pose, radius_m, height_m) <= 0) return std::nullopt;

  OutlineArcs arcs;
  arcs.toward = to_axis / distance;
  arcs.across = d.cross(arcs.toward);
  // The sides touch at the angles +-touch; the camera lies at the angle pi as seen from the axis. A base that faces the
  // camera bounds the outline by its far arc (through the angle 0), the other one by its near arc (through pi).
  const double touch = std::numbers::pi - std::acos(radius_m / distance);
  for (const int base : {0, 1}) {
    const double outward = base == 0 ? -1.0 : 1.0;
    const auto b = static_cast<std::size_t>(base);
    arcs.centers[b] = pose.center_in_cam + outward * height_m / 2 * d;
    const bool faces_camera = outward * d.dot(arcs.centers[b]) < 0;
    arcs.start[b] = outward * touch;
    arcs.span[b] = -outward * (faces_camera ? 2 * touch : 2 * touch - 2 * std::numbers::pi);
  }
  return arcs;
}

std::vector<Eigen::Vector2d> silhouette(const CylinderPose& pose, double radius_m, double height_m,
                                        int samples_per_base) {
  std::vector<Eigen::Vector2d> outline;
  if (nearest_depth(pose, radius_m, height_m) <= 0) return outline;
  outline.reserve(2 * static_cast<std::size_t>(samples_per_base));
  if (const auto arcs = outline_arcs(pose, radius_m, height_m)) {
    for (const int base : {0, 1}) {
      const auto b = static_cast<std::size_t>(base);
      for (int i = 0; i < samples_per_base; ++i) {
        const double share = static_cast<double>(i) / (samples_per_base - 1);
        outline.push_back(to_ray(arcs->point(base, arcs->start[b] + share * arcs->span[b], radius_m)));
      }
    }
    return outline;
  }
  // Inside the infinite cylinder only the near base shows.
  const Eigen::Vector3d& d = pose.axis_in_cam;
  const double outward = d.dot(pose.center_in_cam) > 0 ? -1.0 : 1.0;
  const Eigen::Vector3d base = pose.center_in_cam + outward * height_m / 2 * d;
  const Eigen::Vector3d e1 = d.unitOrthogonal();
  const Eigen::Vector3d e2 = d.cross(e1);
  for (int i = 0; i < 2 * samples_per_base; ++i) {
    const double angle = std::numbers::pi * i / samples_per_base;
    outline.push_back(to_ray(base + radius_m * (std::cos(angle) * e1 + std::sin(angle) * e2)));
  }
  return outline;
}

std::optional<RayHit> intersect_ray(const CylinderPose& pose, double radius_m, double height_m,
                                    const Eigen::Vector3d& direction) {
  const Eigen::Vector3d& d = pose.axis_in_cam;
  const Eigen::Vector3d& center = pose.center_in_cam;
  const double along_direction = direction.dot(d);
  const double along_center = center.dot(d);
  std::optional<RayHit> hit;

  const Eigen::Vector3d across_direction = direction - along_direction * d;
  const Eigen::Vector3d across_center = center - along_center * d;
  const double a = across_direction.squaredNorm();
  const double b = across_direction.dot(across_center);
  const double c = across_center.squaredNorm() - radius_m * radius_m;
  const double discriminant = b * b - a * c;
  if (a > 0 && discriminant > 0) {
    const double t = (b - std::sqrt(discriminant)) / a;
    if (t > 0 && std::abs(t * along_direction - along_center) <= height_m / 2) {
      hit = RayHit{t, (t * across_direction - across_center) / radius_m, false};
    }
  }
  if (along_direction != 0) {
    const double outward = along_direction < 0 ? 1.0 : -1.0;  // the base whose outside the ray can meet
    const double t = (along_center + outward * height_m / 2) / along_direction;
    if (t > 0 && (!hit || t < hit->t) && (t * across_direction - across_center).squaredNorm() <= radius_m * radius_m) {
      hit = RayHit{t, outward * d, true};
    }
  }
  return hit;
}

}  // namespace cylpose
