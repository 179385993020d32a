// Whether the part ends where an outline does whose end is not seen: what hides an end shows no other one.
#pragma once

#include <cylpose/camera.hpp>
#include <cylpose/contour.hpp>
#include <cylpose/cylinder.hpp>
#include <cylpose/outline.hpp>
#include <cylpose/part.hpp>
#include <cylpose/pose_solver.hpp>
#include <optional>
#include <span>
#include <string>

namespace cylpose {

/// Edge points this far inside the outline that do not belong to it are clutter. So far outside the part's colour
/// should not be seen: an occluder takes of it, but adds none.
inline constexpr double kClutterMarginPx = 3;

/// Three tests of the end at `base` (0 or 1), each of which says why the part cannot end there, or nothing. Keeps
/// references: what it is made from must outlive it.
class EndCheck {
 public:
  EndCheck(const CameraModel& camera, const PartModel& part, const SolveOptions& options)
      : camera_(camera), part_(part), options_(options) {}

  /// Both sides go on beyond it. One alone may be an occluder's edge. `points`: all edge points.
  [[nodiscard]] std::optional<std::string> longer_part(const Outline& outline, std::size_t base,
                                                       std::span<const EdgePoint> points) const;

  /// The rim of an end is seen at another place along the axis, by points that the outline leaves unexplained. What
  /// fits a straight line better, or is seen so flat that it might, is an occluder's edge.
  [[nodiscard]] std::optional<std::string> part_of_other_length(const CylinderPose& pose, std::size_t base,
                                                                std::span<const EdgePoint> unexplained) const;

  /// A rim is seen inside the outline, whatever its tilt: where the part is taken to go on, behind an occluder whose
  /// edge would be round just there.
  [[nodiscard]] std::optional<std::string> end_inside(const Outline& outline, std::size_t base,
                                                      std::span<const EdgePoint> unexplained) const;

 private:
  // How far a side goes on beyond the end at `base`, by the edge points on its line there, in pixels.
  [[nodiscard]] double overrun_px(const Outline& outline, std::size_t side, std::size_t base,
                                  std::span<const EdgePoint> points) const;

  const CameraModel& camera_;
  const PartModel& part_;
  const SolveOptions& options_;
};

}  // namespace cylpose
