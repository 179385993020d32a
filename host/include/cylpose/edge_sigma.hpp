// How well edges are located, apart from their noise.
#pragma once

#include <cylpose/edge_field.hpp>

namespace cylpose {

/// Standard deviations, in pixels, of what all edge points of half a side or base have in common (shading, blur), by
/// what told where they are: it does not average out over the points and bounds a covariance from below. Halves err
/// independently, so that turns of a side are covered like shifts. A half of 24 points has all of it in common, longer
/// ones less, down to a fourth. Points also weigh the less the larger it is. The values are those of rendered scenes
/// (docs/accuracy.md).
struct CommonEdgeSigma {
  double by_share_px = 0.0125;
  double by_limb_px = 0.05;
  double by_slope_px = 0.12;
  double by_none_px = 0.2;
  /// Of the whole outline: before an overexposed background everything seems smaller.
  double by_clipped_px = 0.4;

  [[nodiscard]] constexpr double of(EdgeCue cue) const {
    switch (cue) {
      case EdgeCue::kShare:
        return by_share_px;
      case EdgeCue::kLimb:
        return by_limb_px;
      case EdgeCue::kSlope:
        return by_slope_px;
      case EdgeCue::kClipped:
        return by_clipped_px;
      case EdgeCue::kNone:
        break;
    }
    return by_none_px;
  }
};

}  // namespace cylpose
