#include "scenario_parts.hpp"

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

namespace cylpose {

double radians(double degrees) {
  return degrees * std::numbers::pi / 180;
}

Eigen::Vector3d axis_at(const Eigen::Vector3d& center_in_cam, double angle_deg, double turn_deg) {
  const Eigen::Vector3d sight = center_in_cam.normalized();
  const Eigen::Vector3d right = Eigen::Vector3d::UnitY().cross(sight).normalized();
  const Eigen::Vector3d up = right.cross(sight);
  const double turn = radians(turn_deg);
  const double angle = radians(angle_deg);
  return std::cos(angle) * sight + std::sin(angle) * (std::cos(turn) * up + std::sin(turn) * right);
}

PaintedPart painted_part(const std::string& name, double hue_deg, double hue_tolerance_deg) {
  PaintedPart part;
  part.model.name = name;
  part.model.radius_m = kStandardRadiusM;
  part.model.height_m = kStandardHeightM;
  part.model.hue_lo_deg = std::fmod(hue_deg - hue_tolerance_deg + 360, 360);
  part.model.hue_hi_deg = std::fmod(hue_deg + hue_tolerance_deg, 360);
  part.model.min_saturation = 0.2;
  part.model.min_value = 0.15;
  part.material.texture.color = linear_from_hsv(hue_deg, 0.9, 0.85);
  part.material.specular = 0.12;
  part.material.exponent = 25;
  return part;
}

ScenePart at_pose(const PaintedPart& part, const CylinderPose& pose) {
  return {{pose, part.model.radius_m, part.model.height_m}, part.material};
}

Material grey(double light, double specular) {
  Material material;
  material.texture.color = LinearRgb::Constant(light);
  material.specular = specular;
  return material;
}

Solid turned_box(const Eigen::Vector3d& center_in_cam, const Eigen::Vector3d& size_m, double turn_deg,
                 const Material& material) {
  const Eigen::Matrix3d turned = Eigen::AngleAxisd(radians(turn_deg), Eigen::Vector3d::UnitZ()).toRotationMatrix();
  return {BoxSolid{center_in_cam, turned, size_m / 2}, material};
}

Solid rod(const Eigen::Vector3d& from_in_cam, const Eigen::Vector3d& to_in_cam, double radius_m,
          const Material& material) {
  const Eigen::Vector3d along = to_in_cam - from_in_cam;
  return {CylinderSolid{{(from_in_cam + to_in_cam) / 2, along.normalized()}, radius_m, along.norm()}, material};
}

Texture pale_sky() {
  return {TextureKind::kGradient, linear_from_hsv(210, 0.12, 0.72), linear_from_hsv(210, 0.04, 0.9), 0.6, 0};
}

Texture grey_clouds(std::uint32_t seed) {
  return {TextureKind::kNoise, LinearRgb::Constant(0.08), LinearRgb::Constant(0.45), 0.1, seed};
}

}  // namespace cylpose
