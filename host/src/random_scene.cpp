#include <algorithm>
#include <array>
#include <cmath>
#include <cylpose/cylinder.hpp>

#include "portable_random.hpp"
#include "scenario_parts.hpp"

namespace cylpose {
namespace {

constexpr double kMarginPx = 6;           // of the outline from the image's border
constexpr double kMinSightAngleDeg = 30;  // of the axis from the line of sight: the sides show

bool is_inside_image(const CylinderPose& pose, const PartModel& part, const CameraModel& camera) {
  const auto outline = silhouette(pose, part.radius_m, part.height_m);
  return !outline.empty() && std::all_of(outline.begin(), outline.end(), [&](const Eigen::Vector2d& ray) {
    const Eigen::Vector2d pixel = project(camera, {ray.x(), ray.y(), 1});
    return pixel.x() >= kMarginPx && pixel.x() <= camera.width - 1 - kMarginPx && pixel.y() >= kMarginPx &&
           pixel.y() <= camera.height - 1 - kMarginPx;
  });
}

CylinderPose random_pose(const PartModel& part, const CameraModel& camera, PortableRandom* random) {
  for (;;) {
    const double x = random->uniform(0, camera.width - 1);
    const double y = random->uniform(0, camera.height - 1);
    const double distance = random->uniform(0.8, 5);
    const Eigen::Vector3d sight((x - camera.cx) / camera.fx, (y - camera.cy) / camera.fy, 1);
    // Uniform over the sphere outside the cone around the line of sight.
    const double cosine = random->uniform(-1, 1) * std::cos(radians(kMinSightAngleDeg));
    const double angle_deg = std::acos(cosine) / radians(1);
    const Eigen::Vector3d center = distance * sight.normalized();
    CylinderPose pose{center, axis_at(center, angle_deg, random->uniform(0, 360))};
    if (is_inside_image(pose, part, camera)) return pose;
  }
}

// Of any kind, its colours at least 90 degrees of hue from the part's.
Texture random_background(double part_hue_deg, PortableRandom* random) {
  const auto color = [&] {
    const double hue_deg = part_hue_deg + 180 + random->uniform(-90, 90);
    const double saturation = random->uniform(0, 0.6);
    return linear_from_hsv(hue_deg, saturation, random->uniform(0.03, 0.95));
  };
  constexpr std::array kKinds = {TextureKind::kPlain,   TextureKind::kGradient, TextureKind::kNoise,
                                 TextureKind::kChecker, TextureKind::kWood,     TextureKind::kFoil};
  Texture texture;
  texture.kind = kKinds[static_cast<std::size_t>(random->index(static_cast<int>(kKinds.size())))];
  texture.color = color();
  texture.second = color();
  texture.scale = random->uniform(0.03, 0.2);
  texture.seed = static_cast<std::uint32_t>(random->index(1 << 20));
  return texture;
}

Lighting random_light(PortableRandom* random) {
  Lighting light;
  light.ambient = random->uniform(0.15, 0.4);
  light.key = 1 - light.ambient;
  light.light_in_cam = {random->uniform(-1, 1), random->uniform(-1, 0.3), random->uniform(-1, -0.3)};
  return light;
}

}  // namespace

RandomScene random_scene(std::uint64_t seed) {
  PortableRandom random(mixed(seed));
  const double hue_deg = random.uniform(0, 360);
  PaintedPart part = painted_part("cylinder", hue_deg);
  part.material.specular = random.uniform(0, 0.15);
  RandomScene result;
  result.part = part.model;
  result.scene.camera = scenario_camera();
  result.scene.parts = {at_pose(part, random_pose(part.model, result.scene.camera, &random))};
  result.scene.background = random_background(hue_deg, &random);
  result.scene.lighting = random_light(&random);
  result.degrade.blur_sigma_px = random.uniform(0.4, 1);
  result.degrade.noise_sigma = random.uniform(0.5, 2.5);
  result.degrade.seed = mixed(seed + 1);
  return result;
}

}  // namespace cylpose
