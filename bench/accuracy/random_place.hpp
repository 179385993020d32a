// Random placement of the part and of what hides it.
#pragma once

#include <cstdint>
#include <cylpose/part.hpp>
#include <cylpose/scene.hpp>
#include <random>

namespace cylpose::bench {

/// std::mt19937_64 is fixed by the standard, the distributions of <random> are not.
class Dice {
 public:
  explicit Dice(std::uint64_t seed) : engine_(seed) {}

  /// Uniform in [low, high).
  [[nodiscard]] double between(double low, double high) {
    return low + (high - low) * static_cast<double>(engine_() >> 11) * 0x1p-53;
  }
  [[nodiscard]] std::size_t index(std::size_t count) {
    return static_cast<std::size_t>(between(0, static_cast<double>(count)));
  }
  [[nodiscard]] std::uint64_t bits() { return engine_(); }

 private:
  std::mt19937_64 engine_;
};

/// A pose at the distance (of the centre), the axis at an angle within the tilts to the line of sight, anywhere in the
/// image but wholly inside of it.
[[nodiscard]] CylinderPose random_pose(const CameraModel& camera, const PartModel& part, double distance_m,
                                       double least_tilt_deg, double most_tilt_deg, Dice* dice);

/// The camera cut to the part's surroundings: the box around its outline and `margin_px` more on every side. It sees
/// the same pixels of the same scene.
[[nodiscard]] CameraModel cut_to_part(const CameraModel& camera, const PartModel& part, const CylinderPose& pose,
                                      int margin_px);

/// A flat bar nearer to the camera that hides the share of the part's extent across the bar, at a random place of it;
/// the bar runs across the part's axis, give or take 30 degrees.
[[nodiscard]] BoxSolid random_bar(const PartModel& part, const CylinderPose& pose, double share, Dice* dice);

/// Whether the box hides the place (pixels of the ideal camera) from the camera, given that it is nearer.
[[nodiscard]] bool hides(const CameraModel& camera, const BoxSolid& box, const Eigen::Vector2d& position_px);

}  // namespace cylpose::bench
