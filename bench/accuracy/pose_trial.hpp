// The scenes of the accuracy bench: one trial is one scene, seen in one picture or several.
#pragma once

#include <cstdint>
#include <cylpose/part.hpp>
#include <cylpose/render.hpp>
#include <cylpose/scene.hpp>
#include <string>
#include <string_view>
#include <vector>

namespace cylpose::bench {

/// What a camera makes of a trial's light.
struct PictureOfTrial {
  std::string variant;  ///< "nominal", or what is different
  DegradeOptions degrade;
  bool by_thesis = false;  ///< the thesis's method has a go, too
};

struct PoseTrial {
  std::string group;     ///< "random", "beyond", or "scenario"
  std::string scenario;  ///< the kind of background and light, or the scenario's name
  int number = 0;        ///< within the group
  double tilt_deg = 0;   ///< angle of axis and line of sight, 0..90
  int occlusion_percent = 0;
  Scene scene;  ///< parts[0] is the one to find
  PartModel part;
  std::vector<std::size_t> occluders;  ///< boxes among scene.others that hide some of the part
  bool has_bound = true;               ///< false where something else may hide some of it
  std::vector<PictureOfTrial> pictures;

  [[nodiscard]] const CylinderPose& truth() const { return scene.parts[0].cylinder.pose; }
  [[nodiscard]] double distance_m() const { return truth().center_in_cam.norm(); }
};

/// The variant with noise 1.5 and blur 0.6 px that most requirements are stated for.
inline constexpr const char* kNominal = "nominal";

/// Random scenes of the cylinder r = 0.05 m, h = 0.4 m over background and light x distance (1, 1.5, 3, 5 m) x tilt x
/// occlusion (0, 25, 50 %): every trial takes one level of each, every level of one is taken equally often. Each is
/// seen with nominal noise and blur, and with one other noise or blur. The same count and seed give the same scenes.
[[nodiscard]] std::vector<PoseTrial> random_trials(int count, std::uint64_t seed);

/// Lower ends and upper end of the tilts of random_trials, degrees.
inline constexpr double kTiltLevels[] = {0, 15, 30, 50, 75, 90};

/// Random scenes without occluders, in which surfaces and camera do what the method does not model. Each seen nominally
/// and in one picture for every other kind of camera; every third has a rough or glossy surface or hard light instead.
[[nodiscard]] std::vector<PoseTrial> beyond_trials(int count, std::uint64_t seed);

/// Frames of `cylpose synth`'s scenarios, evenly spread over the motion.
[[nodiscard]] std::vector<PoseTrial> scenario_trials(std::string_view scenario, int count, std::uint64_t seed);

}  // namespace cylpose::bench
