// Algorithm 5.5: the pose from two lines (section 3.3.4). All image points are ideal pixels relative to the principal
// point, so u = f x / z and v = f y / z (equation 2.13); z points forward, where the thesis's simulator had it
// backward.
#include <Eigen/Geometry>
#include <cmath>
#include <cylpose/thesis.hpp>
#include <utility>

namespace cylpose {
namespace {

// Two lines closer to parallel than this are taken as this far from it: at 0 equations 3.21 to 3.23 come to 0/0, a
// removable singularity. 1e-7 rad moves the axis by some 1e-6 rad and leaves seven digits.
constexpr double kParallelRad = 1e-7;
// |sin| of the angle between two planes (or two directions) from which they are one: far above what kParallelRad makes
// of a line and itself, far below a pixel.
constexpr double kSameAngle = 1e-6;

std::nullopt_t refuse(std::string* why, std::string reason) {
  if (why != nullptr) *why = std::move(reason);
  return std::nullopt;
}

// A line in the point form that equation 2.17 wants: all points foot + lambda * direction (equations 3.7 and 3.8, with
// the foot of the perpendicular from the principal point as (c, d), and (g, h) = (-sin rho, cos rho)).
struct PointForm {
  Eigen::Vector2d normal;
  Eigen::Vector2d foot;       // (c, d)
  Eigen::Vector2d direction;  // (g, h)
};

PointForm point_form(const Eigen::Vector2d& normal, double delta) {
  return {normal, delta * normal, {-normal.y(), normal.x()}};
}

// Normal of the plane through the camera centre and the line: (h f, -g f, d g - c h), from equation 2.15.
Eigen::Vector3d plane_normal(const PointForm& line, double focal_px) {
  const auto [c, d] = std::pair(line.foot.x(), line.foot.y());
  const auto [g, h] = std::pair(line.direction.x(), line.direction.y());
  return {h * focal_px, -g * focal_px, d * g - c * h};
}

// The second line with its normal on the same side as the first one's, and not exactly parallel to it.
PointForm oriented_like(const PointForm& first, const ImageLine& second) {
  const double sign = first.normal.dot(second.normal) < 0 ? -1 : 1;
  Eigen::Vector2d normal = sign * second.normal;
  const double turn = first.normal.x() * normal.y() - first.normal.y() * normal.x();
  if (std::abs(turn) < kParallelRad) normal = Eigen::Rotation2Dd(kParallelRad) * first.normal;
  return point_form(normal, sign * second.distance);
}

// Direction (g0, h0) of the line midway between two lines whose normals point alike: equation 3.11. Its normal is the
// sum of theirs, which is stable for parallel lines, where the difference that 3.11 uses vanishes.
Eigen::Vector2d middle_direction(const PointForm& first, const PointForm& second) {
  const Eigen::Vector2d normal = (first.normal + second.normal).normalized();
  return {-normal.y(), normal.x()};
}

// The point of the axis' line {anchor + s * direction} that is closest to the viewing ray through `mean_px`. None when
// the ray runs along the axis.
std::optional<Eigen::Vector3d> closest_to_ray(const Eigen::Vector3d& anchor, const Eigen::Vector3d& direction,
                                              const Eigen::Vector2d& mean_px, double focal_px) {
  const Eigen::Vector3d ray = Eigen::Vector3d(mean_px.x(), mean_px.y(), focal_px).normalized();
  const double cosine = ray.dot(direction);
  const double sine_squared = 1 - cosine * cosine;
  if (sine_squared < kSameAngle * kSameAngle) return std::nullopt;
  const double along = (cosine * ray.dot(anchor) - direction.dot(anchor)) / sine_squared;
  return anchor + along * direction;
}

}  // namespace

double thesis_focal_px(const CameraModel& camera) {
  return std::sqrt(camera.fx * camera.fy);
}

std::vector<Eigen::Vector2d> thesis_ideal_points(const CameraModel& camera, std::span<const Eigen::Vector2d> pixels) {
  std::vector<Eigen::Vector2d> points = undistorted(camera, pixels);
  for (Eigen::Vector2d& point : points) point *= thesis_focal_px(camera);
  return points;
}

std::optional<CylinderPose> thesis_pose_from_lines(const ImageLine& first_line, const ImageLine& second_line,
                                                   const Eigen::Vector2d& mean_px, double focal_px, double radius_m,
                                                   std::string* why) {
  const PointForm first = point_form(first_line.normal, first_line.distance);
  const PointForm second = oriented_like(first, second_line);
  const double f = focal_px;

  // Equation 2.17: both sides are parallel to the axis, so it lies in both planes.
  const Eigen::Vector3d first_plane = plane_normal(first, f);
  const Eigen::Vector3d second_plane = plane_normal(second, f);
  const Eigen::Vector3d along = first_plane.cross(second_plane);
  if (along.norm() < kSameAngle * first_plane.norm() * second_plane.norm()) {
    return refuse(why, "the two side lines are one line");
  }
  const Eigen::Vector3d b = along.normalized();

  // Equations 3.9 to 3.14: p on the first line, q on the second, the line between them across the middle line. p must
  // be the foot of the perpendicular: docs/thesis.md, "Not an arbitrary point".
  const Eigen::Vector2d middle = middle_direction(first, second);
  const auto [g0, h0] = std::pair(middle.x(), middle.y());
  const Eigen::Vector2d across(-h0, g0);
  const Eigen::Vector2d p = first.foot;
  const double j = middle.dot(p - second.foot) / middle.dot(second.direction);
  const Eigen::Vector2d q = second.foot + j * second.direction;
  const double i = across.dot(q - p);
  const auto [up, vp] = std::pair(p.x(), p.y());

  // Equations 3.19 to 3.23: P - Q = 2 r (cos(phi) e2 - sin(phi) e1), which takes P and Q as the ends of a diameter.
  const Eigen::Vector3d e1 = b.unitOrthogonal();
  const Eigen::Vector3d e2 = b.cross(e1);
  const double a_321 = h0 * (e2.z() * vp - f * e2.y()) + g0 * (e2.z() * up - f * e2.x());
  const double b_322 = h0 * (f * e1.y() - e1.z() * vp) + g0 * (f * e1.x() - e1.z() * up);
  const double phi = std::atan2(-a_321, b_322);
  const Eigen::Vector3d chord = 2 * radius_m * (std::cos(phi) * e2 - std::sin(phi) * e1);

  // Equation 3.24 or 3.25, whichever divides by the larger number. phi is known up to half a turn; the half turn
  // changes the sign of the chord and of both depths.
  const bool upright = std::abs(h0) > std::abs(g0);
  const double signed_zq =
      upright ? (f * chord.x() - chord.z() * up) / (h0 * i) : (chord.z() * vp - f * chord.y()) / (g0 * i);
  const double zq = std::abs(signed_zq);
  const double zp = zq + std::copysign(1.0, signed_zq) * chord.z();
  if (!std::isfinite(zq) || zq <= 0 || zp <= 0) {
    return refuse(why, "the two side lines have no cylinder of this radius in front of the camera");
  }

  const Eigen::Vector3d point_p = zp / f * Eigen::Vector3d(up, vp, f);
  const Eigen::Vector3d point_q = zq / f * Eigen::Vector3d(q.x(), q.y(), f);
  const auto center = closest_to_ray(0.5 * (point_p + point_q), b, mean_px, f);
  if (!center) return refuse(why, "the camera looks along the axis");
  if (center->z() <= 0) return refuse(why, "the centre would lie behind the camera");
  return with_fixed_sign({*center, b});
}

}  // namespace cylpose
