// A manipulator with grey links and joints of which the forearm is the part to find (thesis figure 5.6).
#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "scenario_parts.hpp"

namespace cylpose {
namespace {

struct ArmAngles {
  double yaw_deg;         ///< of the arm's plane about the upright, 0: parallel to the image plane
  double upper_lift_deg;  ///< of the upper arm above the horizontal
  double fore_lift_deg;   ///< of the forearm above the horizontal
};

// Puts the arm's solids into the scene and the forearm into its parts.
void add_arm(const Eigen::Vector3d& shoulder_in_cam, const ArmAngles& angles, const PaintedPart& forearm,
             Scene* scene) {
  const double yaw = radians(angles.yaw_deg);
  const Eigen::Vector3d up = -Eigen::Vector3d::UnitY();
  const Eigen::Vector3d outward(std::cos(yaw), 0, -std::sin(yaw));
  const Eigen::Vector3d hinge = outward.cross(up);
  const auto lifted = [&](double lift_deg) -> Eigen::Vector3d {
    return std::cos(radians(lift_deg)) * outward + std::sin(radians(lift_deg)) * up;
  };
  const Eigen::Vector3d upper = lifted(angles.upper_lift_deg);
  const Eigen::Vector3d fore = lifted(angles.fore_lift_deg);
  const Material paint = grey(0.55, 0.2);
  const Material metal = grey(0.25, 0.4);

  const Eigen::Vector3d elbow = shoulder_in_cam + 0.46 * upper;
  const Eigen::Vector3d part_start = elbow + 0.11 * fore;
  const Eigen::Vector3d wrist = part_start + (kStandardHeightM + 0.05) * fore;
  auto& solids = scene->others;
  solids.push_back(rod(shoulder_in_cam - 0.8 * up, shoulder_in_cam - 0.07 * up, 0.1, paint));
  solids.push_back(rod(shoulder_in_cam - 0.09 * hinge, shoulder_in_cam + 0.09 * hinge, 0.085, metal));
  solids.push_back(rod(shoulder_in_cam, elbow, 0.05, paint));
  solids.push_back(rod(elbow - 0.075 * hinge, elbow + 0.075 * hinge, 0.07, metal));
  solids.push_back(rod(elbow, part_start, 0.04, metal));
  scene->parts.push_back(at_pose(forearm, {part_start + kStandardHeightM / 2 * fore, fore}));
  solids.push_back(rod(wrist - 0.05 * fore, wrist, 0.035, metal));
  solids.push_back({SphereSolid{wrist, 0.055}, paint});
  // The gripper: a palm and two fingers beside the line of the forearm.
  Eigen::Matrix3d cam_from_hand;
  cam_from_hand << fore, hinge, fore.cross(hinge);
  const auto in_hand = [&](double along, double aside) -> Eigen::Vector3d {
    return wrist + along * fore + aside * hinge.cross(fore);
  };
  solids.push_back({BoxSolid{in_hand(0.07, 0), cam_from_hand, {0.015, 0.02, 0.06}}, metal});
  for (const double aside : {-0.05, 0.05}) {
    solids.push_back({BoxSolid{in_hand(0.13, aside), cam_from_hand, {0.05, 0.015, 0.01}}, metal});
  }
}

Scenario arm_scenario(const std::string& name, const std::string& description, const PaintedPart& forearm) {
  Scenario scenario;
  scenario.name = name;
  scenario.description = description;
  scenario.camera = scenario_camera();
  scenario.parts = {forearm.model};
  return scenario;
}

}  // namespace

Scenario still_arm() {
  const PaintedPart forearm = painted_part("forearm", 222);
  Scenario scenario = arm_scenario("fig5.6", "manipulator with a blue forearm (thesis fig. 5.6)", forearm);
  scenario.scene_at = [=](double) {
    Scene scene;
    scene.camera = scenario_camera();
    scene.background = pale_sky();
    add_arm({-0.45, 0.2, 1.7}, {25, 70, -12}, forearm, &scene);
    return scene;
  };
  return scenario;
}

Scenario moving_arm() {
  const PaintedPart forearm = painted_part("forearm", 212);
  Scenario scenario = arm_scenario(
      "manipulator", "arm on a satellite moves its blue forearm, hard sunlight, black sky, foil and a violet panel",
      forearm);
  scenario.frames = 100;
  scenario.scene_at = [=](double share) {
    Scene scene;
    scene.camera = scenario_camera();
    scene.background.color = LinearRgb::Constant(0.0008);
    scene.lighting.ambient = 0.1;
    scene.lighting.key = 0.9;
    scene.lighting.light_in_cam = {-0.5, -0.55, -0.6};
    scene.lighting.hard_shadows = true;
    Material foil;
    foil.texture = {TextureKind::kFoil, linear_from_hsv(40, 0.75, 0.8), LinearRgb(1.4, 1.1, 0.6), 0.12, 7};
    scene.others.push_back(turned_box({-0.75, 0.75, 2.4}, {1.3, 0.8, 0.5}, -6, foil));
    // Near the forearm's hue, but outside its gate.
    Material panel;
    panel.texture = {TextureKind::kChecker, linear_from_hsv(262, 0.65, 0.45), linear_from_hsv(258, 0.6, 0.55), 0.11, 0};
    scene.others.push_back(turned_box({0.95, -0.35, 2.9}, {1.1, 0.66, 0.02}, 17, panel));
    const double phase = 2 * std::numbers::pi * share;
    add_arm({-0.5, 0.28, 1.8}, {38 * std::sin(phase), 78 + 18 * std::sin(phase + 1), -8 - 20 * std::cos(1.5 * phase)},
            forearm, &scene);
    return scene;
  };
  return scenario;
}

}  // namespace cylpose
