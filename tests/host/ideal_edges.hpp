// Edge fields as a perfect backend would deliver them, made from the exact outline of a pose.
#pragma once

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cylpose/camera.hpp>
#include <cylpose/curved_border.hpp>
#include <cylpose/cylinder.hpp>
#include <cylpose/edge_field.hpp>
#include <cylpose/part.hpp>
#include <functional>
#include <map>
#include <random>
#include <utility>
#include <vector>

namespace cylpose::testing {

inline CameraModel test_camera() {
  CameraModel camera;
  camera.width = 1280;
  camera.height = 720;
  camera.fx = camera.fy = 1215;
  camera.cx = 639.5;
  camera.cy = 359.5;
  return camera;
}

inline PartModel test_part() {
  return {"link", 0.05, 0.4, 200, 260, 0.3, 0.1};
}

/// Sees all of the outline unless `is_visible` (of the pixel position) says otherwise; places have Gaussian noise of
/// `noise_px` along their normals, and on round borders the shift that locating them makes unless they are `on_border`.
struct IdealEdges {
  double noise_px = 0;
  unsigned seed = 1;
  bool on_border = false;
  std::function<bool(const Eigen::Vector2d&)> is_visible = [](const Eigen::Vector2d&) { return true; };
};

inline PartEdges ideal_edges(const CameraModel& camera, const PartModel& part, const CylinderPose& pose,
                             const IdealEdges& how = {}) {
  std::mt19937 random(how.seed);
  std::normal_distribution<double> noise(0, how.noise_px > 0 ? how.noise_px : 1);
  std::vector<Eigen::Vector2d> outline;
  for (const Eigen::Vector2d& ray : silhouette(pose, part.radius_m, part.height_m, 2000)) {
    outline.push_back(ideal_pixel(camera, {ray.x(), ray.y(), 1}));
  }
  double twice_area = 0;
  for (std::size_t i = 0; i < outline.size(); ++i) {
    const Eigen::Vector2d& a = outline[i];
    const Eigen::Vector2d& b = outline[(i + 1) % outline.size()];
    twice_area += a.x() * b.y() - a.y() * b.x();
  }
  const double turn = twice_area > 0 ? 1 : -1;

  // Of the arcs; a corner bends at one end of the pieces beside it, a side at neither.
  const auto curvature = [&](std::size_t i) {
    const auto vertex = [&](std::size_t k) { return outline[k % outline.size()]; };
    const auto bend_at = [&](std::size_t k) {
      const Eigen::Vector2d before = vertex(k) - vertex(k + outline.size() - 1);
      const Eigen::Vector2d after = vertex(k + 1) - vertex(k);
      const double turned = std::atan2(before.x() * after.y() - before.y() * after.x(), before.dot(after));
      return std::abs(turned) / std::max(before.norm(), after.norm());
    };
    return std::min(bend_at(i), bend_at(i + 1));
  };

  std::map<std::pair<int, int>, EdgePixel> pixels;  // (row, column): row-major
  PartEdges field;
  for (std::size_t i = 0; i < outline.size(); ++i) {
    const Eigen::Vector2d& a = outline[i];
    const Eigen::Vector2d& b = outline[(i + 1) % outline.size()];
    const double length = (b - a).norm();
    if (length < 1e-9) continue;
    const Eigen::Vector2d along = (b - a) / length;
    const Eigen::Vector2d inward = turn * Eigen::Vector2d(-along.y(), along.x());
    const double shift = how.on_border ? 0 : inward_shift_px(std::min(curvature(i), kMaxCurvature));
    for (double at = 0; at < length; at += 0.25) {
      const Eigen::Vector2d position = a + at * along;
      const int x = static_cast<int>(std::lround(position.x()));
      const int y = static_cast<int>(std::lround(position.y()));
      if (x < 0 || y < 0 || x >= camera.width || y >= camera.height || !how.is_visible(position)) continue;
      if (pixels.contains({y, x})) continue;
      const double error = how.noise_px > 0 ? noise(random) : 0;
      const double offset = inward.dot(position - Eigen::Vector2d(x, y)) + shift + error;
      pixels[{y, x}] = {static_cast<std::int16_t>(x),
                        static_cast<std::int16_t>(y),
                        static_cast<std::int16_t>(std::lround(800 * inward.x())),
                        static_cast<std::int16_t>(std::lround(800 * inward.y())),
                        static_cast<std::int16_t>(std::lround(256 * offset)),
                        EdgeStrength::kStrong,
                        EdgeCue::kShare};
    }
  }
  for (const auto& [place, pixel] : pixels) field.edges.push_back(pixel);

  // The region: all pixels that the cylinder covers.
  const auto [min_x, max_x] =
      std::minmax_element(outline.begin(), outline.end(), [](const auto& p, const auto& q) { return p.x() < q.x(); });
  const auto [min_y, max_y] =
      std::minmax_element(outline.begin(), outline.end(), [](const auto& p, const auto& q) { return p.y() < q.y(); });
  for (int y = std::max(0, static_cast<int>(min_y->y())); y <= std::min(camera.height - 1.0, max_y->y()); ++y) {
    for (int x = std::max(0, static_cast<int>(min_x->x())); x <= std::min(camera.width - 1.0, max_x->x()); ++x) {
      const Eigen::Vector2d pixel(x, y);
      if (how.is_visible(pixel) && intersect_ray(pose, part.radius_m, part.height_m, ideal_ray(camera, pixel))) {
        field.region.add(x, y);
        field.region.box = united(field.region.box, {x, y, 1, 1});
      }
    }
  }
  return field;
}

inline EdgeField field_of(const CameraModel& camera, PartEdges edges) {
  EdgeField field;
  field.searched = {0, 0, camera.width, camera.height};
  field.parts.push_back(std::move(edges));
  return field;
}

/// Angle between two axes regardless of their signs, radians.
inline double axis_angle(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return std::atan2(a.cross(b).norm(), std::abs(a.dot(b)));
}

/// A pose whose sides and bases lie inside the test camera's image, the axis at least 30 degrees off the line of sight.
inline CylinderPose random_pose(std::mt19937& random, const PartModel& part) {
  const CameraModel camera = test_camera();
  std::uniform_real_distribution<double> unit(-1, 1);
  while (true) {
    // One draw a statement: compilers differ in the order of arguments.
    const double axis_z = unit(random);
    const double axis_y = unit(random);
    const double axis_x = unit(random);
    const Eigen::Vector3d axis(axis_x, axis_y, axis_z);
    const double z = 2.4 + 1.6 * unit(random);
    const CylinderPose pose{{0.4 * z * unit(random), 0.2 * z * unit(random), z}, axis.normalized()};
    if (axis.norm() > 1 || axis.norm() < 0.1) continue;
    if (axis_angle(pose.axis_in_cam, pose.center_in_cam) < 0.52) continue;
    bool inside = true;
    for (const Eigen::Vector2d& ray : silhouette(pose, part.radius_m, part.height_m)) {
      const Eigen::Vector2d pixel = ideal_pixel(camera, {ray.x(), ray.y(), 1});
      inside = inside && pixel.x() > 10 && pixel.y() > 10 && pixel.x() < 1269 && pixel.y() < 709;
    }
    if (inside) return pose;
  }
}

}  // namespace cylpose::testing
