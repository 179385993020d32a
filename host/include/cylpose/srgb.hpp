// The sRGB transfer function (IEC 61966-2-1) between light and codes, both 0..1.
#pragma once

#include <cmath>

namespace cylpose {

/// Share of the largest code for a share of the largest light.
[[nodiscard]] inline double srgb_from_linear(double light) {
  return light <= 0.0031308 ? 12.92 * light : 1.055 * std::pow(light, 1 / 2.4) - 0.055;
}

/// Share of the largest light for a share of the largest code.
[[nodiscard]] inline double linear_from_srgb(double code) {
  return code <= 0.04045 ? code / 12.92 : std::pow((code + 0.055) / 1.055, 2.4);
}

}  // namespace cylpose
