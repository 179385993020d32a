#include <algorithm>
#include <cmath>
#include <cylpose/scene.hpp>
#include <cylpose/srgb.hpp>

namespace cylpose {

LinearRgb linear_from_hsv(double hue_deg, double saturation, double value) {
  // Each channel falls linearly from full to none over 60 degrees, 60 degrees away from its own hue.
  const auto channel = [&](double own_hue_deg) {
    const double away_deg = std::abs(std::remainder(hue_deg - own_hue_deg, 360.0));
    const double share = std::clamp(2 - away_deg / 60, 0.0, 1.0);
    return linear_from_srgb(value * (1 - saturation * (1 - share)));
  };
  return {channel(0), channel(120), channel(240)};
}

Solid solid_at(const Scene& scene, std::size_t index) {
  if (index < scene.parts.size()) return {scene.parts[index].cylinder, scene.parts[index].material};
  return scene.others[index - scene.parts.size()];
}

}  // namespace cylpose
