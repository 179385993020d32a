// The test series of the thesis: figures 5.8 to 5.11.
#include <cmath>

#include "scenario_parts.hpp"

namespace cylpose {
namespace {

Scenario series(const std::string& name, const std::string& description, const PaintedPart& part) {
  Scenario scenario;
  scenario.name = name;
  scenario.description = description;
  scenario.frames = 100;
  scenario.camera = scenario_camera();
  scenario.parts = {part.model};
  return scenario;
}

// A scene of one part alone, its pose a function of the share of the motion.
template <typename PoseAt>
std::function<Scene(double)> alone(const PaintedPart& part, const Texture& background, const PoseAt& pose_at) {
  return [=](double share) {
    Scene scene;
    scene.camera = scenario_camera();
    scene.background = background;
    scene.parts = {at_pose(part, pose_at(share))};
    return scene;
  };
}

// The way from 5 m to 0.85 m, somewhat beside the optical axis as nothing is ever centred on it.
Eigen::Vector3d approaching(double share) {
  return {0.03, 0.01, std::lerp(5.0, 0.85, share)};
}

Scenario series1() {
  const PaintedPart part = painted_part("cylinder", 135);
  Scenario scenario =
      series("series1", "upright cylinder approaches along z from 5 m to 0.85 m (thesis fig. 5.8)", part);
  scenario.scene_at = alone(part, pale_sky(), [](double share) {
    return CylinderPose{approaching(share), -Eigen::Vector3d::UnitY()};
  });
  return scenario;
}

Scenario series2() {
  const PaintedPart part = painted_part("cylinder", 225);
  Scenario scenario =
      series("series2", "cylinder tilted by 45 degrees approaches from 5 m to 0.85 m (thesis fig. 5.9)", part);
  scenario.scene_at = alone(part, grey_clouds(2), [](double share) {
    return CylinderPose{approaching(share), Eigen::Vector3d(1, -1, 0).normalized()};
  });
  return scenario;
}

Scenario series3() {
  const PaintedPart part = painted_part("cylinder", 0);
  Scenario scenario =
      series("series3", "cylinder at 1.5 m turns by 180 degrees about the optical axis (thesis fig. 5.10)", part);
  scenario.scene_at = alone(part, pale_sky(), [](double share) {
    const double turn = radians(180 * share);
    return CylinderPose{{0.05, -0.03, 1.5}, {std::sin(turn), -std::cos(turn), 0}};
  });
  return scenario;
}

Scenario series4() {
  const PaintedPart part = painted_part("cylinder", 135);
  Scenario scenario = series(
      "series4",
      "cylinder tumbles and drifts below 1 m, its axis 33 to 87 degrees off the line of sight (thesis fig. 5.11)",
      part);
  scenario.scene_at = alone(part, grey_clouds(4), [](double share) {
    const double phase = radians(360 * share);
    const Eigen::Vector3d center(-0.12 + 0.24 * share, 0.02 * std::sin(phase), std::lerp(0.96, 0.84, share));
    return CylinderPose{center, axis_at(center, 60 + 27 * std::sin(1.5 * phase), 20 + 130 * share)};
  });
  return scenario;
}

}  // namespace

std::vector<Scenario> test_series() {
  return {series1(), series2(), series3(), series4()};
}

}  // namespace cylpose
