// Where edges of a round border are located: not quite on it.
#pragma once

namespace cylpose {

/// How far inside of a border its edges are located, in pixels, where it bends by `curvature` (1/px, the part on the
/// inner side of the bend). To first order that is a quarter of it for three lines averaged 1 : 2 : 1 (locate.hpp), and
/// half the variance of pixel and lens: 0.25 px^2 with a blur of 0.65 px. Measured with 0.6 px: 0.5 to 0.6 times the
/// curvature before a background, 0.4 before black.
[[nodiscard]] constexpr double inward_shift_px(double curvature) {
  return 0.5 * curvature;
}

/// What bends more (1/px) does so within the reach of the filters that locate edges: these tell too little of it.
inline constexpr double kMaxCurvature = 1.0 / 3;

}  // namespace cylpose
