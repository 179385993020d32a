// Images as cylpose sees them: a view of somebody else's pixels, never a copy.
#pragma once

#include <cstddef>
#include <cstdint>

namespace cylpose {

enum class PixelFormat : std::uint8_t { kBgr8, kRgb8, kGray8 };

constexpr int bytes_per_pixel(PixelFormat format) {
  return format == PixelFormat::kGray8 ? 1 : 3;
}

/// Axis-parallel rectangle of pixels: columns [x, x + width), rows [y, y + height).
struct Roi {
  int x = 0;
  int y = 0;
  int width = 0;
  int height = 0;

  [[nodiscard]] constexpr bool empty() const { return width <= 0 || height <= 0; }
  [[nodiscard]] constexpr int right() const { return x + width; }    ///< first column outside
  [[nodiscard]] constexpr int bottom() const { return y + height; }  ///< first row outside
  [[nodiscard]] constexpr bool contains(int px, int py) const {
    return px >= x && px < right() && py >= y && py < bottom();
  }
  friend constexpr bool operator==(const Roi&, const Roi&) = default;
};

/// The pixels that both rectangles hold; empty (all zero) where they do not meet.
[[nodiscard]] Roi intersection(const Roi& a, const Roi& b);

/// The smallest rectangle that holds both; an empty one adds nothing.
[[nodiscard]] Roi united(const Roi& a, const Roi& b);

/// `roi` with width and height larger by `fraction`, centre kept (rounded outward), cut to the image `width` x
/// `height`.
[[nodiscard]] Roi enlarged(const Roi& roi, double fraction, int width, int height);

/// Interleaved 8-bit pixels, row by row. Pixel (0,0) is the top-left one, its centre has the coordinates (0,0).
struct ImageView {
  const std::uint8_t* data = nullptr;
  int width = 0;
  int height = 0;
  std::ptrdiff_t stride = 0;  ///< bytes from one row to the next, at least width * bytes_per_pixel(format)
  PixelFormat format = PixelFormat::kBgr8;

  [[nodiscard]] const std::uint8_t* row(int y) const { return data + y * stride; }
  [[nodiscard]] Roi bounds() const { return {0, 0, width, height}; }
};

/// Throws Error(kInput) unless the view has pixels: non-null data, 1 to 32767 columns and rows, a stride that holds a
/// row.
void require_usable(const ImageView& image);

}  // namespace cylpose
