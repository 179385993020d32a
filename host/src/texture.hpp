// Procedural colours. They are band-limited enough for one sample a pixel, but for the checker, whose squares report
// themselves as different surfaces.
#pragma once

#include <cstdint>
#include <cylpose/scene.hpp>

namespace cylpose {

struct TextureSample {
  LinearRgb color;
  std::uint32_t cell;  ///< 0 or 1; the colour jumps where it changes
};

[[nodiscard]] TextureSample sample(const Texture& texture, double x, double y);

}  // namespace cylpose
