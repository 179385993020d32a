#include "texture.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "portable_random.hpp"

namespace cylpose {
namespace {

double value_at_node(std::int64_t x, std::int64_t y, std::uint64_t seed) {
  const auto node = static_cast<std::uint64_t>(x) * 0x9e3779b97f4a7c15ULL + static_cast<std::uint64_t>(y);
  return unit_interval(mixed(mixed(node) + seed));
}

// Random values 0..1 on the integer grid with a smooth surface through them.
double value_noise(double x, double y, std::uint64_t seed) {
  const double fx = std::floor(x);
  const double fy = std::floor(y);
  const auto ix = static_cast<std::int64_t>(fx);
  const auto iy = static_cast<std::int64_t>(fy);
  const auto ease = [](double t) { return t * t * (3 - 2 * t); };
  const double sx = ease(x - fx);
  const double top = std::lerp(value_at_node(ix, iy, seed), value_at_node(ix + 1, iy, seed), sx);
  const double bottom = std::lerp(value_at_node(ix, iy + 1, seed), value_at_node(ix + 1, iy + 1, seed), sx);
  return std::lerp(top, bottom, ease(y - fy));
}

// Three octaves, 0..1.
double clouds(double x, double y, std::uint64_t seed) {
  return (4 * value_noise(x, y, seed) + 2 * value_noise(2 * x, 2 * y, seed + 1) + value_noise(4 * x, 4 * y, seed + 2)) /
         7;
}

LinearRgb between(const Texture& texture, double share) {
  return texture.color + share * (texture.second - texture.color);
}

// Year rings cut at a small angle: the phase runs with y and wanders slowly along x; fine fibres on top.
double wood_share(double x, double y, std::uint64_t seed) {
  const double phase = y + 2.5 * value_noise(0.12 * x, 0.25 * y, seed);
  const double ring = 0.5 + 0.5 * std::sin(2 * std::numbers::pi * phase);
  return 0.7 * ring * ring + 0.3 * value_noise(0.5 * x, 8 * y, seed + 1);
}

// Slopes of the crumpled sheet from folded noise, a lamp beside the camera.
LinearRgb foil_color(const Texture& texture, double x, double y) {
  const auto folded = [](double n) { return 2 * std::abs(2 * n - 1) - 0.7; };
  const Eigen::Vector3d slopes(folded(clouds(x, y, texture.seed)), folded(clouds(x, y, texture.seed + 3)), 1);
  const double facing = slopes.dot(Eigen::Vector3d(0.35, 0.25, 0.9)) / slopes.norm();
  const double glint = std::pow(std::max(0.0, facing), 40);
  return texture.color * (0.15 + 0.6 * std::max(0.0, facing)) + texture.second * glint;
}

}  // namespace

TextureSample sample(const Texture& texture, double x, double y) {
  const double sx = x / texture.scale;
  const double sy = y / texture.scale;
  switch (texture.kind) {
    case TextureKind::kPlain:
      break;
    case TextureKind::kGradient:
      return {between(texture, std::clamp(0.5 + sy, 0.0, 1.0)), 0};
    case TextureKind::kNoise:
      return {between(texture, clouds(sx, sy, texture.seed)), 0};
    case TextureKind::kChecker: {
      const auto cell = static_cast<std::uint32_t>(static_cast<std::int64_t>(std::floor(sx) + std::floor(sy)) & 1);
      return {cell == 0 ? texture.color : texture.second, cell};
    }
    case TextureKind::kWood:
      return {between(texture, wood_share(sx, sy, texture.seed)), 0};
    case TextureKind::kFoil:
      return {foil_color(texture, sx, sy), 0};
  }
  return {texture.color, 0};
}

}  // namespace cylpose
