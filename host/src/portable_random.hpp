// Random numbers that are the same with every standard library: std::mt19937_64 is fixed by the standard, the
// distributions of <random> are not.
#pragma once

#include <array>
#include <cstdint>
#include <random>

namespace cylpose {

/// A well mixed 64-bit hash: the finaliser of SplitMix (Steele, Lea and Flood 2014).
constexpr std::uint64_t mixed(std::uint64_t bits) {
  bits = (bits ^ (bits >> 30)) * 0xbf58476d1ce4e5b9ULL;
  bits = (bits ^ (bits >> 27)) * 0x94d049bb133111ebULL;
  return bits ^ (bits >> 31);
}

/// The upper 53 bits as a number in [0, 1).
constexpr double unit_interval(std::uint64_t bits) {
  return static_cast<double>(bits >> 11) * 0x1p-53;
}

class PortableRandom {
 public:
  explicit PortableRandom(std::uint64_t seed) : engine_(seed) {}

  /// Uniform in [low, high).
  double uniform(double low, double high) { return low + (high - low) * unit_interval(engine_()); }

  /// One of 0 .. count-1.
  int index(int count) { return static_cast<int>(uniform(0, count)); }

  /// Normal with mean 0 and variance 1.
  double gaussian();

 private:
  double gaussian_tail(bool negative);

  std::mt19937_64 engine_;
};

}  // namespace cylpose
