// Random images for the tests of the backends.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cylpose/image.hpp>
#include <random>
#include <vector>

namespace cylpose::testing {

/// An image that owns its pixels; rows may be longer than the pixels need, the rest is random too.
struct TestImage {
  int width;
  int height;
  std::ptrdiff_t stride;
  PixelFormat format;
  std::vector<std::uint8_t> bytes;

  TestImage(int columns, int rows, PixelFormat pixel_format = PixelFormat::kBgr8, int padding = 0)
      : width(columns),
        height(rows),
        stride(std::ptrdiff_t{columns} * bytes_per_pixel(pixel_format) + padding),
        format(pixel_format),
        bytes(static_cast<std::size_t>(stride) * static_cast<std::size_t>(rows)) {}

  [[nodiscard]] ImageView view() const { return {bytes.data(), width, height, stride, format}; }
  [[nodiscard]] std::uint8_t* pixel(int x, int y) {
    return bytes.data() + y * stride + std::ptrdiff_t{x} * bytes_per_pixel(format);
  }
};

inline void fill_with_noise(TestImage& image, std::mt19937& random) {
  std::uniform_int_distribution<int> code(0, 255);
  for (std::uint8_t& byte : image.bytes) byte = static_cast<std::uint8_t>(code(random));
}

/// Noise with overlapping rectangles of random colours, so that masks have areas, holes and specks.
inline TestImage random_image(int width, int height, std::mt19937& random, PixelFormat format = PixelFormat::kBgr8,
                              int padding = 0) {
  TestImage image(width, height, format, padding);
  fill_with_noise(image, random);
  std::uniform_int_distribution<int> code(0, 255);
  std::uniform_int_distribution<int> exposed(0, 320);  // some channels clipped
  for (int i = 0; i < 6; ++i) {
    const int x0 = std::uniform_int_distribution<int>(0, width - 1)(random);
    const int y0 = std::uniform_int_distribution<int>(0, height - 1)(random);
    const int x1 = std::uniform_int_distribution<int>(x0, width - 1)(random);
    const int y1 = std::uniform_int_distribution<int>(y0, height - 1)(random);
    const int color[3] = {exposed(random), exposed(random), exposed(random)};
    for (int y = y0; y <= y1; ++y) {
      for (int x = x0; x <= x1; ++x) {
        if (code(random) < 12) continue;  // holes
        for (int c = 0; c < bytes_per_pixel(format); ++c)
          image.pixel(x, y)[c] = static_cast<std::uint8_t>(std::min(255, color[c]));
      }
    }
  }
  return image;
}

/// The pixels of `roi` alone.
inline TestImage cropped(const ImageView& image, const Roi& roi) {
  TestImage result(roi.width, roi.height, image.format);
  const int bytes = bytes_per_pixel(image.format);
  for (int y = 0; y < roi.height; ++y) {
    for (int i = 0; i < roi.width * bytes; ++i) result.pixel(0, y)[i] = image.row(roi.y + y)[roi.x * bytes + i];
  }
  return result;
}

}  // namespace cylpose::testing
