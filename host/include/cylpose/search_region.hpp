// Where to look in the next frame (thesis algorithm 5.3: the region of the last frame, enlarged by a fourth).
#pragma once

#include <cylpose/camera.hpp>
#include <cylpose/image.hpp>
#include <cylpose/part.hpp>
#include <cylpose/pose.hpp>
#include <optional>
#include <span>
#include <vector>

namespace cylpose {

/// Carries the search region from frame to frame: the box around the outlines of all parts of the last frame, enlarged
/// by a fourth of its size and by at least `kMinMarginPx` on every side. The whole image while a part is missing.
class SearchRegion {
 public:
  explicit SearchRegion(const CameraModel& camera) : camera_(camera), next_(whole()) {}

  [[nodiscard]] const Roi& next() const { return next_; }
  [[nodiscard]] Roi whole() const { return {0, 0, camera_.width, camera_.height}; }

  /// Takes the estimates of a frame, one per part.
  void update(std::span<const PartModel> parts, std::span<const PoseEstimate> estimates);

  static constexpr int kMinMarginPx = 16;

 private:
  CameraModel camera_;
  Roi next_;
};

/// The pixels that the part's outline covers, cut to the image. Empty when the outline cannot be seen.
[[nodiscard]] Roi outline_box(const CameraModel& camera, const PartModel& part, const CylinderPose& pose);

}  // namespace cylpose
