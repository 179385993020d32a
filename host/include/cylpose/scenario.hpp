// Ready-made synthetic sequences by name: the single cases and test series of the thesis (chapter 5.1.2) and the cases
// that it leaves open; and random scenes for tests.
#pragma once

#include <cstdint>
#include <cylpose/part.hpp>
#include <cylpose/render.hpp>
#include <cylpose/scene.hpp>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

namespace cylpose {

/// A motion before a camera. Frames sample it evenly from start to end, however many there are.
struct Scenario {
  std::string name;
  std::string description;
  int frames = 1;             ///< that the motion is meant to be seen with
  double frame_rate_hz = 10;  ///< at that number of frames
  CameraModel camera;
  std::vector<PartModel> parts;  ///< to look for; the scene's parts, in their order
  double blur_sigma_px = 0.6;
  double noise_sigma = 1.5;               ///< code values
  std::function<Scene(double)> scene_at;  ///< of the share 0..1 of the motion

  /// Frame `frame` of `frame_count`. Throws Error(kInput) unless 0 <= frame < frame_count.
  [[nodiscard]] Scene scene(int frame, int frame_count) const;
  [[nodiscard]] Scene scene(int frame) const { return scene(frame, frames); }

  /// Frame rate that plays `frame_count` frames in the motion's own time.
  [[nodiscard]] double rate_for(int frame_count) const;
};

/// All scenarios, the thesis's first.
[[nodiscard]] const std::vector<Scenario>& scenarios();

/// Throws Error(kInput) that lists the known names.
[[nodiscard]] const Scenario& find_scenario(std::string_view name);

/// The camera of all scenarios: 1280x720, focal length 1215 px as the thesis's webcam, centred, no distortion.
[[nodiscard]] CameraModel scenario_camera();

/// A still picture of which a method under test knows only what it may: camera, part and image.
struct RandomScene {
  Scene scene;
  PartModel part;  ///< of scene.parts[0]
  DegradeOptions degrade;
};

/// The cylinder of r = 0.05 m, h = 0.4 m in a random pose at 0.8 to 5 m, wholly inside the image, the axis more than 30
/// degrees from the line of sight, in random colour and light before a random background of other hue. The same seed
/// gives the same scene everywhere.
[[nodiscard]] RandomScene random_scene(std::uint64_t seed);

}  // namespace cylpose
