// The colour gate: does a pixel have the part's colour, and how much of it? Integers only, no division, so that every
// backend and device gives the same answer (docs/algorithm.md, "Hue without HSV").
#pragma once

#include <algorithm>
#include <cstdint>
#include <cylpose/part.hpp>

namespace cylpose {

/// Coefficients of the gate for one part, as every backend uses them.
/// For a hue h let c(h) be the colour of the RGB hexagon's corner walk and n(h) = (1,1,1) x c(h). A pixel p lies in
/// [lo, hi] (less than 180 degrees wide) exactly when n(lo).p >= 0 and n(hi).p <= 0; a wider range is the complement.
/// n sums to zero, so n.p = n_r (R-G) + n_b (B-G).
struct ColorGate {
  std::int32_t lo_r, lo_b;      ///< n(lo), scaled to at most 64
  std::int32_t hi_r, hi_b;      ///< n(hi)
  std::int32_t wide;            ///< 1: hue range of 180 degrees or more, either test suffices; 0: both must hold
  std::int32_t any_hue;         ///< 1: the hue range is the whole circle
  std::int32_t saturation_256;  ///< floor of (max-min)/max in 1/256; at least 1 unless any_hue
  std::int32_t value;           ///< floor of max, 0..255; at least 1 unless any_hue
  std::int32_t response_r;      ///< projection on the mid hue in 1/64, at most 69; the G coefficient is minus the sum
  std::int32_t response_b;
  std::int32_t aside_r;  ///< what a hue beside it takes away, in 1/64 of either sign, at most 128; G as above
  std::int32_t aside_b;
  friend bool operator==(const ColorGate&, const ColorGate&) = default;
};

/// The gate of a valid part.
[[nodiscard]] ColorGate make_gate(const PartModel& part);

/// True when the colour lies in the gate. Codes 0..255.
[[nodiscard]] constexpr bool passes(const ColorGate& gate, int r, int g, int b) {
  const int high = std::max({r, g, b});
  const int low = std::min({r, g, b});
  if (high < gate.value || (high - low) * 256 < gate.saturation_256 * high) {
    return false;
  }
  const bool above_lo = gate.lo_r * (r - g) + gate.lo_b * (b - g) >= 0;
  const bool below_hi = gate.hi_r * (r - g) + gate.hi_b * (b - g) <= 0;
  return gate.any_hue != 0 || (gate.wide != 0 ? above_lo || below_hi : above_lo && below_hi);
}

/// Grey images carry no hue: the value floor alone decides.
[[nodiscard]] constexpr bool passes_gray(const ColorGate& gate, int value) {
  return value >= gate.value;
}

/// How strongly a pixel shows the part's colour, 0..255: projection on the mid hue less a share of what is
/// perpendicular to it; 255 for the fully saturated mid hue, 0 for greys and from 20 degrees outside the range on (35
/// to 90 degrees from the mid hue), so that the part also stands out from a background of near hue. A part of any hue
/// has no such direction: there it is the chroma (max - min) when the part has a saturation floor, else the value
/// (max). Grey images: the code itself.
[[nodiscard]] constexpr int response(const ColorGate& gate, int r, int g, int b) {
  if (gate.any_hue != 0) {
    return std::max({r, g, b}) - (gate.saturation_256 != 0 ? std::min({r, g, b}) : 0);
  }
  const int along = gate.response_r * (r - g) + gate.response_b * (b - g);
  const int aside = gate.aside_r * (r - g) + gate.aside_b * (b - g);
  return std::clamp((along - (aside < 0 ? -aside : aside)) / 64, 0, 255);
}

}  // namespace cylpose
