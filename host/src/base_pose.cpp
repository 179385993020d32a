#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cylpose/base_pose.hpp>
#include <cylpose/circle_pose.hpp>
#include <cylpose/pose.hpp>
#include <numbers>
#include <vector>

namespace cylpose {
namespace {

// The cylinder behind a base that faces the camera (`away`), or before one that does not.
CylinderPose cylinder_of(const CirclePose& base, double height_m, bool away) {
  const double outward = away ? -0.5 : 0.5;
  return {base.center_in_cam + outward * height_m * base.normal_in_cam, base.normal_in_cam};
}

// The largest tilt of the near base at which the camera is still within the infinite cylinder.
double largest_tilt(const CirclePose& near, double radius_m) {
  return std::asin(std::min(1.0, radius_m / near.center_in_cam.norm()));
}

double tilt_of(const CirclePose& near) {
  return std::acos(std::clamp(-near.normal_in_cam.dot(near.center_in_cam.normalized()), -1.0, 1.0));
}

// The circle turned back toward the camera until its cylinder's sides are hidden.
CirclePose with_hidden_sides(CirclePose near, double radius_m) {
  const Eigen::Vector3d toward_camera = -near.center_in_cam.normalized();
  const double tilt = tilt_of(near);
  const double allowed = largest_tilt(near, radius_m);
  if (tilt <= allowed) return near;
  const Eigen::Vector3d aside = (near.normal_in_cam - std::cos(tilt) * toward_camera).normalized();
  near.normal_in_cam = std::cos(allowed) * toward_camera + std::sin(allowed) * aside;
  return near;
}

// Share of the ellipse that was seen: as many sectors as there are circumferential steps of three pixels.
double seen_share(const CameraModel& camera, const FittedEllipse& base, std::span<const EdgePoint> points) {
  constexpr double kStepPx = 3;
  const Eigen::Vector2d center = base.ellipse.center_px();
  const double radius = base.ellipse.half_axes_px().mean();
  const int count = std::clamp(static_cast<int>(2 * std::numbers::pi * radius / kStepPx), 12, 360);
  std::vector<bool> seen(static_cast<std::size_t>(count), false);
  const auto sector = [&](double angle) {
    const double turns = angle / (2 * std::numbers::pi) + 0.5;
    return static_cast<std::size_t>(std::clamp(static_cast<int>(turns * count), 0, count - 1));
  };
  for (const int i : base.points) {
    const Eigen::Vector2d offset = points[static_cast<std::size_t>(i)].position_px - center;
    seen[sector(std::atan2(offset.y(), offset.x()))] = true;
  }
  for (int i = 0; i < count; ++i) {
    const double angle = 2 * std::numbers::pi * ((i + 0.5) / count - 0.5);
    const Eigen::Vector2d place = center + radius * Eigen::Vector2d(std::cos(angle), std::sin(angle));
    if (place.x() < 1 || place.y() < 1 || place.x() > camera.width - 2 || place.y() > camera.height - 2) {
      seen[static_cast<std::size_t>(i)] = true;
    }
  }
  return static_cast<double>(std::count(seen.begin(), seen.end(), true)) / count;
}

// Both circle poses for ellipses a root of five standard deviations away along each of the five directions: sigma
// points of equal weight. What the points have in common adds to the amplitude of every harmonic of the border's error,
// whose own variance is 2 sigma^2 / count.
std::vector<CirclePose> sigma_circles(const CameraModel& camera, const PartModel& part, const FittedEllipse& base,
                                      std::span<const EdgePoint> points, const CommonEdgeSigma& sigma) {
  double squares = 0;
  for (const int i : base.points) squares += std::pow(sigma.of(points[static_cast<std::size_t>(i)].cue), 2);
  const double common = std::sqrt(squares / static_cast<double>(base.points.size())) / std::max(base.rms_px, 1e-3);
  const double step_length = std::sqrt(5 * (1 + common * common * static_cast<double>(base.points.size()) / 2));
  std::vector<CirclePose> all;
  for (Eigen::Index step = 0; step < 5; ++step) {
    for (const double sign : {-1.0, 1.0}) {
      Ellipse moved = base.ellipse;
      moved.coefficients += sign * step_length * base.sigma_steps.col(step);
      if (const auto circles = circle_poses(conic_of_rays(camera, moved), part.radius_m)) {
        all.insert(all.end(), circles->begin(), circles->end());
      }
    }
  }
  return all;
}

// Whether the tilt may be so small that the sides are hidden. Its square is about linear in what is measured.
bool may_hide_sides(const CirclePose& base, const std::vector<CirclePose>& sigma_points, double radius_m) {
  constexpr double kSigmas = 3;
  const auto squared_tilt = [](const CirclePose& circle) { return std::pow(tilt_of(circle), 2); };
  double variance = 0;
  for (const CirclePose& circle : sigma_points) {
    variance += std::pow(squared_tilt(circle) - squared_tilt(base), 2) / static_cast<double>(sigma_points.size());
  }
  return squared_tilt(base) - kSigmas * std::sqrt(variance) <= std::pow(largest_tilt(base, radius_m), 2);
}

}  // namespace

std::vector<CylinderPose> poses_from_bases(const CameraModel& camera, const PartModel& part,
                                           std::span<const FittedEllipse> ellipses) {
  std::vector<CylinderPose> poses;
  for (const FittedEllipse& fitted : ellipses) {
    const auto circles = circle_poses(conic_of_rays(camera, fitted.ellipse), part.radius_m);
    if (!circles) continue;
    for (const CirclePose& circle : *circles) {
      for (const bool away : {true, false}) {
        const CylinderPose pose = cylinder_of(circle, part.height_m, away);
        if (!silhouette(pose, part.radius_m, part.height_m, 2).empty()) poses.push_back(pose);
      }
    }
  }
  return poses;
}

std::vector<CylinderPose> poses_from_blob(const CameraModel& camera, const PartModel& part,
                                          const RegionStatistics& region) {
  const auto area = static_cast<double>(region.m00);
  const Eigen::Vector2d mean(region.mean_x(), region.mean_y());
  const double xx = static_cast<double>(region.m20) / area - mean.x() * mean.x();
  const double yy = static_cast<double>(region.m02) / area - mean.y() * mean.y();
  const double xy = static_cast<double>(region.m11) / area - mean.x() * mean.y();
  const double spread = std::hypot(xx - yy, 2 * xy) / 2;
  const double half_length_px = 2 * std::sqrt((xx + yy) / 2 + spread);
  const double half_width_px = 2 * std::sqrt(std::max(0.0, (xx + yy) / 2 - spread));
  const double focal = std::sqrt(camera.fx * camera.fy);
  const double near_m = focal * part.radius_m / half_width_px;  // distance of the near base
  if (!std::isfinite(near_m)) return {};

  // Two discs, the far one smaller: how far the length goes beyond the width tells how far they lie apart.
  double tilt = 0;
  for (int round = 0; round < 3; ++round) {
    const double far_m = near_m + part.height_m * std::cos(tilt);
    const double apart_px = 2 * half_length_px - half_width_px * (1 + near_m / far_m);
    tilt = std::asin(std::clamp(apart_px * far_m / (focal * part.height_m), 0.0, 1.0));
  }
  const Eigen::Vector3d sight = ideal_ray(camera, mean).normalized();
  const double angle = region.orientation_rad();
  const Eigen::Vector3d along_image(std::cos(angle), std::sin(angle), 0);
  const Eigen::Vector3d aside = (along_image - along_image.dot(sight) * sight).normalized();
  std::vector<CylinderPose> poses;
  for (const double side : {1.0, -1.0}) {
    const Eigen::Vector3d axis = std::cos(tilt) * sight + side * std::sin(tilt) * aside;
    const CylinderPose pose{(near_m + part.height_m / 2 * std::cos(tilt)) * sight, axis};
    if (!silhouette(pose, part.radius_m, part.height_m, 2).empty()) poses.push_back(pose);
  }
  return poses;
}

std::optional<EndOnView> end_on_view(const CameraModel& camera, const PartModel& part, const FittedEllipse& base,
                                     std::span<const EdgePoint> points, const CommonEdgeSigma& common_edge_sigma) {
  const auto measured = circle_poses(conic_of_rays(camera, base.ellipse), part.radius_m);
  const std::vector<CirclePose> circles = sigma_circles(camera, part, base, points, common_edge_sigma);
  if (!measured || circles.empty() || !may_hide_sides((*measured)[0], circles, part.radius_m)) return std::nullopt;
  std::vector<CylinderPose> poses;
  poses.reserve(circles.size());
  for (const CirclePose& circle : circles) {
    poses.push_back(cylinder_of(with_hidden_sides(circle, part.radius_m), part.height_m, true));
  }

  EndOnView view;
  view.pose.center_in_cam.setZero();
  Eigen::Vector3d axis = Eigen::Vector3d::Zero();
  for (const CylinderPose& pose : poses) {
    view.pose.center_in_cam += pose.center_in_cam / static_cast<double>(poses.size());
    axis += pose.axis_in_cam;
  }
  view.pose.axis_in_cam = axis.normalized();
  view.covariance.setZero();
  using Vector6d = Eigen::Matrix<double, 6, 1>;
  for (const CylinderPose& pose : poses) {
    Vector6d off;
    off << pose.center_in_cam - view.pose.center_in_cam, view.pose.axis_in_cam.cross(pose.axis_in_cam);
    view.covariance += off * off.transpose() / static_cast<double>(poses.size());
  }
  view.covariance.bottomRightCorner<3, 3>() +=
      kUnobservableRoll * view.pose.axis_in_cam * view.pose.axis_in_cam.transpose();
  view.rms_px = base.rms_px;
  view.support = static_cast<int>(base.points.size());
  view.seen = seen_share(camera, base, points);
  return view;
}

}  // namespace cylpose
