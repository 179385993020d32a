#include "portable_random.hpp"

#include <cmath>

namespace cylpose {
namespace {

// The ziggurat method (Marsaglia and Tsang 2000): the half bell exp(-x^2/2) is covered by kLayers pieces of equal area,
// the lowest with the tail beyond kTailStart. A point that is uniform in a piece falls under the curve nearly always,
// and mostly one comparison tells so. The two constants belong to kLayers.
constexpr int kLayers = 128;
constexpr double kTailStart = 3.442619855899;
constexpr double kLayerArea = 9.91256303526217e-3;

double bell(double x) {
  return std::exp(-x * x / 2);
}

struct Ziggurat {
  std::array<double, kLayers + 1> width;   // of layer i; layer 0 as if the tail were part of its box
  std::array<double, kLayers + 1> height;  // of the curve at that width

  Ziggurat() : width{}, height{} {
    width[0] = kLayerArea / bell(kTailStart);
    width[1] = kTailStart;
    for (std::size_t i = 2; i < kLayers; ++i) {
      width[i] = std::sqrt(-2 * std::log(kLayerArea / width[i - 1] + bell(width[i - 1])));
    }
    width[kLayers] = 0;
    for (std::size_t i = 0; i <= kLayers; ++i) height[i] = bell(width[i]);
  }
};

}  // namespace

double PortableRandom::gaussian() {
  static const Ziggurat ziggurat;
  for (;;) {
    const std::uint64_t bits = engine_();
    const std::size_t layer = bits & (kLayers - 1);  // below the 53 bits that unit_interval takes
    const double signed_share = 2 * unit_interval(bits) - 1;
    const double x = signed_share * ziggurat.width[layer];
    if (std::abs(x) < ziggurat.width[layer + 1]) return x;
    if (layer == 0) return gaussian_tail(signed_share < 0);
    const double y = uniform(ziggurat.height[layer], ziggurat.height[layer + 1]);
    if (y < bell(x)) return x;
  }
}

double PortableRandom::gaussian_tail(bool negative) {
  // Marsaglia's method for the tail beyond kTailStart. 1 - u is in (0, 1]: no logarithm of zero.
  for (;;) {
    const double x = -std::log(1 - uniform(0, 1)) / kTailStart;
    const double y = -std::log(1 - uniform(0, 1));
    if (2 * y > x * x) return negative ? -(kTailStart + x) : kTailStart + x;
  }
}

}  // namespace cylpose
