#include <algorithm>
#include <cylpose/error.hpp>
#include <cylpose/scenario.hpp>
#include <string>

#include "scenario_parts.hpp"

namespace cylpose {
namespace {

std::vector<Scenario> all_scenarios() {
  std::vector<Scenario> all;
  for (const auto& group : {single_cases(), test_series(), std::vector{moving_arm()}, hard_cases()}) {
    all.insert(all.end(), group.begin(), group.end());
  }
  return all;
}

}  // namespace

Scene Scenario::scene(int frame, int frame_count) const {
  if (frame < 0 || frame >= frame_count) {
    throw Error(ErrorKind::kInput, "scenario " + name + ": frame " + std::to_string(frame) + " is not one of " +
                                       std::to_string(frame_count) + ", counted from 0");
  }
  return scene_at(frame_count == 1 ? 0.0 : static_cast<double>(frame) / (frame_count - 1));
}

double Scenario::rate_for(int frame_count) const {
  if (frame_count < 2 || frames < 2) return frame_rate_hz;
  return frame_rate_hz * (frame_count - 1) / (frames - 1);
}

const std::vector<Scenario>& scenarios() {
  static const std::vector<Scenario> all = all_scenarios();
  return all;
}

const Scenario& find_scenario(std::string_view name) {
  const auto found = std::find_if(scenarios().begin(), scenarios().end(),
                                  [&](const Scenario& scenario) { return scenario.name == name; });
  if (found != scenarios().end()) return *found;
  std::string known;
  for (const Scenario& scenario : scenarios()) known += (known.empty() ? "" : ", ") + scenario.name;
  throw Error(ErrorKind::kInput, "unknown scenario \"" + std::string(name) + "\"; there are " + known);
}

CameraModel scenario_camera() {
  CameraModel camera;
  camera.width = 1280;
  camera.height = 720;
  camera.fx = camera.fy = 1215;
  camera.cx = (camera.width - 1) / 2.0;
  camera.cy = (camera.height - 1) / 2.0;
  return camera;
}

}  // namespace cylpose
