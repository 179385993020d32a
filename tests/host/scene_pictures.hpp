// What the tests of rendered pictures share: small scenes, areas of polygons, the HSV definition.
#pragma once

#include <algorithm>
#include <cylpose/cylinder.hpp>
#include <cylpose/part.hpp>
#include <cylpose/scene.hpp>
#include <opencv2/core.hpp>
#include <vector>

namespace cylpose {

/// 320x240 pixels, the field of view of about 60 degrees, no distortion.
inline CameraModel small_camera() {
  CameraModel camera;
  camera.width = 320;
  camera.height = 240;
  camera.fx = 280;
  camera.fy = 283;
  camera.cx = 161.3;
  camera.cy = 118.8;
  return camera;
}

/// Flat light: every surface shows exactly the colour of its texture.
inline Lighting flat_light() {
  Lighting light;
  light.ambient = 1;
  light.key = 0;
  return light;
}

inline Material plain(const LinearRgb& color) {
  Material material;
  material.texture.color = color;
  return material;
}

/// A white cylinder in flat light before black.
inline Scene white_on_black(const CylinderPose& pose, double radius_m = 0.05, double height_m = 0.4) {
  Scene scene;
  scene.camera = small_camera();
  scene.lighting = flat_light();
  scene.background.color = LinearRgb::Zero();
  scene.parts = {{{pose, radius_m, height_m}, plain(LinearRgb::Ones())}};
  return scene;
}

/// The outline of the scene's part in pixels, lens distortion included.
inline std::vector<Eigen::Vector2d> outline_px(const Scene& scene, std::size_t part = 0) {
  const CylinderSolid& cylinder = scene.parts.at(part).cylinder;
  std::vector<Eigen::Vector2d> outline;
  const auto rays = silhouette(cylinder.pose, cylinder.radius_m, cylinder.height_m, 256);
  for (std::size_t i = 0; i < rays.size(); ++i) {
    // The long sides are straight in space, not in a lens: points along them, too.
    const Eigen::Vector2d& from = rays[i];
    const Eigen::Vector2d& to = rays[(i + 1) % rays.size()];
    constexpr double kStep = 2e-3;  // tangent of the angle
    const int steps = 1 + static_cast<int>((to - from).norm() / kStep);
    for (int k = 0; k < steps; ++k) {
      const Eigen::Vector2d ray = from + (to - from) * k / steps;
      outline.push_back(project(scene.camera, {ray.x(), ray.y(), 1}));
    }
  }
  return outline;
}

struct Polygon {
  double area;
  Eigen::Vector2d centroid;
};

inline Polygon measured(const std::vector<Eigen::Vector2d>& corners) {
  const Eigen::Vector2d origin = corners.front();  // against cancellation
  double twice_area = 0;
  Eigen::Vector2d moment = Eigen::Vector2d::Zero();
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Eigen::Vector2d a = corners[i] - origin;
    const Eigen::Vector2d b = corners[(i + 1) % corners.size()] - origin;
    const double cross = a.x() * b.y() - a.y() * b.x();
    twice_area += cross;
    moment += cross * (a + b);
  }
  return {std::abs(twice_area) / 2, origin + moment / (3 * twice_area)};
}

/// Whether a B G R code passes the part's gate by the definition of HSV, in floating point.
inline bool has_color_of(const PartModel& part, const cv::Vec3b& bgr) {
  const double b = bgr[0];
  const double g = bgr[1];
  const double r = bgr[2];
  const double high = std::max({r, g, b});
  const double spread = high - std::min({r, g, b});
  if (spread == 0 || high / 255 < part.min_value || spread / high < part.min_saturation) return false;
  double hue_deg = 0;
  if (high == r) {
    hue_deg = 60 * (g - b) / spread;
  } else if (high == g) {
    hue_deg = 120 + 60 * (b - r) / spread;
  } else {
    hue_deg = 240 + 60 * (r - g) / spread;
  }
  if (hue_deg < 0) hue_deg += 360;
  return part.hue_lo_deg <= part.hue_hi_deg ? hue_deg >= part.hue_lo_deg && hue_deg <= part.hue_hi_deg
                                            : hue_deg >= part.hue_lo_deg || hue_deg <= part.hue_hi_deg;
}

}  // namespace cylpose
