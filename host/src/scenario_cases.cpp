// Single pictures, as the thesis shows them in figures 5.2 to 5.7.
#include <cmath>

#include "scenario_parts.hpp"

namespace cylpose {
namespace {

constexpr double kHueDeg = 135;

Scenario single(const std::string& name, const std::string& description, const CylinderPose& pose,
                const std::vector<Solid>& occluders = {}) {
  const PaintedPart part = painted_part("cylinder", kHueDeg);
  Scenario scenario;
  scenario.name = name;
  scenario.description = description;
  scenario.camera = scenario_camera();
  scenario.parts = {part.model};
  scenario.scene_at = [=](double) {
    Scene scene;
    scene.camera = scenario_camera();
    scene.background = pale_sky();
    scene.parts = {at_pose(part, pose)};
    scene.others = occluders;
    return scene;
  };
  return scenario;
}

CylinderPose slanted(const Eigen::Vector3d& center_in_cam, double angle_deg, double turn_deg) {
  return {center_in_cam, axis_at(center_in_cam, angle_deg, turn_deg)};
}

Scenario occluded_near_end() {
  const CylinderPose pose = slanted({-0.05, 0.02, 1.1}, 52, -48);
  // The bar stands on the line of sight to a place near the near end (axis_at points away from the camera).
  const Eigen::Vector3d hidden = pose.center_in_cam - 0.17 * pose.axis_in_cam;
  const Solid bar = turned_box(0.75 * hidden, {0.05, 0.5, 0.02}, 12, grey(0.3));
  return single("fig5.5", "arbitrary pose b: a bar hides the near end (thesis fig. 5.5)", pose, {bar});
}

Scenario far_and_occluded() {
  const CylinderPose pose = slanted({0.35, -0.2, 4.6}, 65, 35);
  // One panel over the lower half, a bar along one side of what is left: no two sides to see.
  const Eigen::Vector3d lower = pose.center_in_cam - 0.1 * pose.axis_in_cam;
  const Eigen::Vector3d upper = pose.center_in_cam + 0.1 * pose.axis_in_cam;
  const std::vector<Solid> occluders = {
      turned_box(0.9 * lower, {0.3, 0.2, 0.02}, 35, grey(0.25)),
      turned_box(0.85 * upper + Eigen::Vector3d(0.042, 0.025, 0), {0.06, 0.5, 0.02}, 35, grey(0.4))};
  return single("fig5.7", "far away and mostly hidden; the thesis detects nothing (thesis fig. 5.7)", pose, occluders);
}

}  // namespace

std::vector<Scenario> single_cases() {
  return {single("fig5.2", "upright cylinder parallel to the image plane (thesis fig. 5.2)",
                 {{0.04, -0.01, 1.2}, -Eigen::Vector3d::UnitY()}),
          single("fig5.3", "parallel to the image plane, turned by 40 degrees (thesis fig. 5.3)",
                 {{-0.06, 0.02, 1.2}, {std::sin(radians(40)), -std::cos(radians(40)), 0}}),
          single("fig5.4", "arbitrary pose a: the near end looks larger and draws the blob's mean (thesis fig. 5.4)",
                 slanted({0.08, 0.03, 0.9}, 42, 55)),
          occluded_near_end(),
          still_arm(),
          far_and_occluded()};
}

}  // namespace cylpose
