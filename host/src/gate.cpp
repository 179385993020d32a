#include <array>
#include <cmath>
#include <cylpose/gate.hpp>
#include <numbers>

namespace cylpose {
namespace {

constexpr int kScale = 64;  // coefficients of at most this size keep n.p within 16 bits

// A fraction of a sextant of the hue circle with a small denominator.
struct Fraction {
  int numerator;
  int denominator;
};

// The fraction nearest to `value` (0..1) with a denominator up to kScale. Every whole degree is exact, being so many
// sixtieths; the worst hue error is 0.47 degrees, near the corners of the hexagon.
Fraction nearest_fraction(double value) {
  Fraction best{0, 1};
  double best_error = value;
  for (int denominator = 1; denominator <= kScale; ++denominator) {
    const int numerator = static_cast<int>(std::lround(value * denominator));
    const double error = std::abs(value - static_cast<double>(numerator) / denominator);
    if (error < best_error) {
      best = {numerator, denominator};
      best_error = error;
    }
  }
  return best;
}

// The walk along the corners of the RGB hexagon, in units of 1/denominator: red, yellow, green, cyan, blue, magenta.
std::array<int, 3> corner_color(int sextant, const Fraction& along) {
  const int full = along.denominator;
  const int rising = along.numerator;
  const int falling = full - rising;
  switch (sextant) {
    case 0:
      return {full, rising, 0};
    case 1:
      return {falling, full, 0};
    case 2:
      return {0, full, rising};
    case 3:
      return {0, falling, full};
    case 4:
      return {rising, 0, full};
    default:
      return {full, 0, falling};
  }
}

std::array<int, 3> hue_color(double hue_deg) {
  const double turns = hue_deg / 360 - std::floor(hue_deg / 360);
  const double sextants = turns * 6;
  const int sextant = std::min(static_cast<int>(sextants), 5);
  return corner_color(sextant, nearest_fraction(sextants - sextant));
}

}  // namespace

ColorGate make_gate(const PartModel& part) {
  const double range = part.hue_hi_deg - part.hue_lo_deg;
  const double width = range < 0 ? range + 360 : range;

  ColorGate gate{};
  const auto lo = hue_color(part.hue_lo_deg);
  gate.lo_r = lo[2] - lo[1];  // (1,1,1) x c
  gate.lo_b = lo[1] - lo[0];
  const auto hi = hue_color(part.hue_hi_deg);
  gate.hi_r = hi[2] - hi[1];
  gate.hi_b = hi[1] - hi[0];
  gate.wide = width >= 180 ? 1 : 0;
  gate.any_hue = width >= 360 ? 1 : 0;

  // Greys have no hue, so only a gate that takes any hue may take them.
  const int least = gate.any_hue != 0 ? 0 : 1;
  constexpr double kRounding = 1e-9;  // 0.2 * 255 must not become 52
  gate.saturation_256 = std::max(least, static_cast<int>(std::lround(part.min_saturation * 256)));
  gate.value = std::max(least, static_cast<int>(std::ceil(part.min_value * 255 - kRounding)));

  // Without its grey share the mid hue's colour c is c - mean(c); the scale makes the projection of c itself 1.
  const auto mid = hue_color(part.hue_lo_deg + width / 2);
  const double mean = (mid[0] + mid[1] + mid[2]) / 3.0;
  const double red = mid[0] - mean;
  const double green = mid[1] - mean;
  const double blue = mid[2] - mean;
  const double full = std::max({mid[0], mid[1], mid[2]});
  const double scale = kScale * full / (red * red + green * green + blue * blue);
  gate.response_r = static_cast<int>(std::lround(red * scale));
  gate.response_b = static_cast<int>(std::lround(blue * scale));
  // (1,1,1) x (c - mean(c)) / sqrt(3) is perpendicular to it among the colours without grey, and as long.
  constexpr double kBeyondRangeDeg = 20;
  const double none_from_deg = std::clamp(width / 2 + kBeyondRangeDeg, 35.0, 90.0);
  const double aside_scale = scale / std::tan(none_from_deg * std::numbers::pi / 180) / std::numbers::sqrt3;
  gate.aside_r = static_cast<int>(std::lround((blue - green) * aside_scale));
  gate.aside_b = static_cast<int>(std::lround((green - red) * aside_scale));
  return gate;
}

}  // namespace cylpose
