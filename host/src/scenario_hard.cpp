// Cases that the thesis leaves open: an occluder that comes and stays, and its candle with truth.
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "scenario_parts.hpp"

namespace cylpose {
namespace {

Scenario occlusion() {
  const PaintedPart part = painted_part("cylinder", 0);
  Scenario scenario;
  scenario.name = "occlusion";
  scenario.description =
      "a bar half as wide as the cylinder is long comes in over one end until it hides the middle half";
  scenario.frames = 100;
  scenario.camera = scenario_camera();
  scenario.parts = {part.model};
  scenario.scene_at = [=](double share) {
    constexpr double kTurnDeg = 62;
    const Eigen::Vector3d center(0.02, 0.01, 1.2);
    const CylinderPose pose{center, axis_at(center, 80, kTurnDeg)};
    Scene scene;
    scene.camera = scenario_camera();
    scene.background = grey_clouds(5);
    scene.parts = {at_pose(part, pose)};
    // The bar's middle runs along the axis, as seen from the camera, from outside the end to the centre. Its x axis
    // lies along the image of the cylinder's axis, which axis_at counts from upright.
    const double nearness = 0.85;
    const double along_m = std::lerp(0.34, 0.0, share);
    scene.others.push_back(turned_box(nearness * (center + along_m * pose.axis_in_cam),
                                      {nearness * kStandardHeightM / 2, 0.7, 0.02}, kTurnDeg - 90, grey(0.3)));
    return scene;
  };
  return scenario;
}

Scenario along_the_axis() {
  const PaintedPart part = painted_part("cylinder", 0);
  Scenario scenario;
  scenario.name = "along";
  scenario.description =
      "the axis turns from 28 degrees off the line of sight onto it: in the end only the near base shows";
  scenario.frames = 100;
  scenario.camera = scenario_camera();
  scenario.parts = {part.model};
  scenario.scene_at = [=](double share) {
    const Eigen::Vector3d center(0.1, -0.05, std::lerp(1.1, 1.6, share));
    Scene scene;
    scene.camera = scenario_camera();
    scene.background = grey_clouds(9);
    scene.parts = {at_pose(part, {center, axis_at(center, std::lerp(28.0, 0.0, share), 40 + 100 * share)})};
    return scene;
  };
  return scenario;
}

PaintedPart candle_part() {
  PaintedPart candle = painted_part("candle", 8, 14);
  candle.model.radius_m = 0.0395;
  candle.model.height_m = 0.27;
  candle.model.min_saturation = 0.6;  // the wood's is lower
  candle.material.texture.color = linear_from_hsv(8, 0.85, 0.85);
  candle.material.specular = 0.03;  // wax
  candle.material.exponent = 12;
  return candle;
}

Scenario candle_on_table() {
  const PaintedPart candle = candle_part();
  Scenario scenario;
  scenario.name = "candle";
  scenario.description =
      "orange-red candle (r = 0.0395 m, h = 0.27 m) on a wooden board turns at 1.1 m, then the camera comes to 0.6 m";
  scenario.frames = 100;
  scenario.camera = scenario_camera();
  scenario.parts = {candle.model};
  scenario.scene_at = [=](double share) {
    const double turn = std::clamp(2 * share, 0.0, 1.0);          // first half
    const double approach = std::clamp(2 * share - 1, 0.0, 1.0);  // second half
    // Table frame: z up from the table toward the camera, which looks down 12 degrees off the plumb line.
    const Eigen::Matrix3d cam_from_table =
        Eigen::AngleAxisd(std::numbers::pi - radians(12), Eigen::Vector3d::UnitX()).toRotationMatrix();
    const Eigen::Vector3d up = cam_from_table.col(2);
    const Eigen::Vector3d center(0.015, -0.01, std::lerp(1.1, 0.6, approach));
    const double yaw = radians(12 + 110 * turn);
    const Eigen::Vector3d axis = cam_from_table * Eigen::Vector3d(std::cos(yaw), std::sin(yaw), 0);

    constexpr double kBoardThicknessM = 0.018;
    const Eigen::Vector3d on_board = center - candle.model.radius_m * up;
    const Eigen::Matrix3d cam_from_board =
        cam_from_table * Eigen::AngleAxisd(radians(25), Eigen::Vector3d::UnitZ()).toRotationMatrix();
    Material wood;
    wood.texture = {TextureKind::kWood, linear_from_hsv(33, 0.48, 0.78), linear_from_hsv(30, 0.52, 0.6), 0.02, 3};
    Material metal;
    metal.texture = {TextureKind::kNoise, LinearRgb::Constant(0.3), LinearRgb::Constant(0.42), 0.05, 11};
    metal.specular = 0.25;

    Scene scene;
    scene.camera = scenario_camera();
    scene.lighting.ambient = 0.35;
    scene.lighting.key = 0.6;
    scene.lighting.at_infinity = false;
    scene.lighting.light_in_cam = center + cam_from_table * Eigen::Vector3d(-0.9, 0.5, 1.6);
    scene.lighting.hard_shadows = true;
    scene.parts = {at_pose(candle, {center, axis})};
    scene.others = {
        {BoxSolid{on_board - kBoardThicknessM / 2 * up, cam_from_board, {0.24, 0.19, kBoardThicknessM / 2}}, wood},
        {BoxSolid{on_board - (kBoardThicknessM + 0.02) * up, cam_from_table, {1.5, 1.2, 0.02}}, metal}};
    return scene;
  };
  return scenario;
}

}  // namespace

std::vector<Scenario> hard_cases() {
  return {occlusion(), along_the_axis(), candle_on_table()};
}

}  // namespace cylpose
