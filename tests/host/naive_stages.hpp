// The per-pixel stages once more, straight from their definitions: no separation, no cropping, floating-point angles.
// Slow and obvious; the serial backend has to agree with it exactly.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cylpose/backend.hpp>
#include <cylpose/gate.hpp>
#include <functional>
#include <numbers>
#include <vector>

namespace cylpose::testing {

class NaiveStages {
 public:
  NaiveStages(const ImageView& image, const Roi& search, const PartModel& part, const DetectOptions& options)
      : image_(image), search_(search), gate_(make_gate(part)), options_(options) {
    mask_ = per_pixel([&](int x, int y) { return gated(x, y); });
    mask_ = grown(shrunk(mask_));
  }

  [[nodiscard]] std::vector<std::uint8_t> mask() const {
    std::vector<std::uint8_t> bytes;
    for (const bool set : mask_) bytes.push_back(set ? 255 : 0);
    return bytes;
  }

  [[nodiscard]] RegionStatistics region() const {
    RegionStatistics region;
    int left = 1 << 20, right = -1, top = 1 << 20, bottom = -1;
    for_each([&](int x, int y) {
      if (!at(mask_, x, y)) return;
      region.add(x, y);
      left = std::min(left, x);
      right = std::max(right, x);
      top = std::min(top, y);
      bottom = std::max(bottom, y);
    });
    if (region.m00 > 0) region.box = {left, top, right - left + 1, bottom - top + 1};
    return region;
  }

  /// Offsets are zero.
  [[nodiscard]] std::vector<EdgePixel> edges() const {
    const Plane wide = grown(grown(mask_));
    const Plane core = shrunk(shrunk(mask_));
    std::vector<EdgePixel> edges;
    for_each([&](int x, int y) {
      if (!at(wide, x, y) || at(core, x, y)) return;
      const auto [gx, gy] = sobel(x, y);
      const double slope = std::sqrt(squared(x, y)) / 8;
      if (slope < options_.edge_low) return;
      const int octant = static_cast<int>(std::lround(std::atan2(gy, gx) / (std::numbers::pi / 4)));
      const int dx = static_cast<int>(std::lround(std::cos(octant * std::numbers::pi / 4)));
      const int dy = static_cast<int>(std::lround(std::sin(octant * std::numbers::pi / 4)));
      if (squared(x, y) <= squared(x + dx, y + dy) || squared(x, y) < squared(x - dx, y - dy)) return;
      edges.push_back({static_cast<std::int16_t>(x), static_cast<std::int16_t>(y), static_cast<std::int16_t>(gx),
                       static_cast<std::int16_t>(gy), 0,
                       slope >= options_.edge_high ? EdgeStrength::kStrong : EdgeStrength::kWeak});
    });
    return edges;
  }

 private:
  using Plane = std::vector<bool>;
  struct Vector {
    int x, y;
  };

  void for_each(const std::function<void(int, int)>& visit) const {
    for (int y = search_.y; y < search_.bottom(); ++y) {
      for (int x = search_.x; x < search_.right(); ++x) visit(x, y);
    }
  }
  [[nodiscard]] Plane per_pixel(const std::function<bool(int, int)>& value) const {
    Plane plane;
    for_each([&](int x, int y) { plane.push_back(value(x, y)); });
    return plane;
  }
  [[nodiscard]] bool at(const Plane& plane, int x, int y) const {
    return plane[static_cast<std::size_t>((y - search_.y) * search_.width + x - search_.x)];
  }
  [[nodiscard]] int count_around(const Plane& plane, bool value, int x, int y) const {
    int count = 0;
    for (int j = y - 1; j <= y + 1; ++j) {
      for (int i = x - 1; i <= x + 1; ++i) count += search_.contains(i, j) && at(plane, i, j) == value ? 1 : 0;
    }
    return count;
  }
  [[nodiscard]] Plane shrunk(const Plane& plane) const {
    return per_pixel([&](int x, int y) { return count_around(plane, false, x, y) == 0; });
  }
  [[nodiscard]] Plane grown(const Plane& plane) const {
    return per_pixel([&](int x, int y) { return count_around(plane, true, x, y) > 0; });
  }

  struct Color {
    int r, g, b;
  };
  [[nodiscard]] Color color(int x, int y) const {
    const std::uint8_t* p = image_.row(y) + x * bytes_per_pixel(image_.format);
    if (image_.format == PixelFormat::kGray8) return {p[0], p[0], p[0]};
    return image_.format == PixelFormat::kBgr8 ? Color{p[2], p[1], p[0]} : Color{p[0], p[1], p[2]};
  }
  [[nodiscard]] bool gated(int x, int y) const {
    const Color c = color(x, y);
    return image_.format == PixelFormat::kGray8 ? passes_gray(gate_, c.r) : passes(gate_, c.r, c.g, c.b);
  }
  [[nodiscard]] int level(int x, int y) const {
    const Color c =
        color(std::clamp(x, search_.x, search_.right() - 1), std::clamp(y, search_.y, search_.bottom() - 1));
    return image_.format == PixelFormat::kGray8 ? c.r : response(gate_, c.r, c.g, c.b);
  }
  [[nodiscard]] Vector sobel(int x, int y) const {
    if (!search_.contains(x, y)) return {0, 0};
    Vector sum{0, 0};
    for (int j = -1; j <= 1; ++j) {
      for (int i = -1; i <= 1; ++i) {
        sum.x += i * (2 - std::abs(j)) * level(x + i, y + j);
        sum.y += j * (2 - std::abs(i)) * level(x + i, y + j);
      }
    }
    return sum;
  }
  [[nodiscard]] int squared(int x, int y) const {
    const Vector g = sobel(x, y);
    return g.x * g.x + g.y * g.y;
  }

  ImageView image_;
  Roi search_;
  ColorGate gate_;
  DetectOptions options_;
  Plane mask_;
};

}  // namespace cylpose::testing
