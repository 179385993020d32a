#include "serial/morphology.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>

namespace cylpose::serial {
namespace {

struct And {
  std::uint8_t operator()(std::uint8_t a, std::uint8_t b) const { return a & b; }
};
struct Or {
  std::uint8_t operator()(std::uint8_t a, std::uint8_t b) const { return a | b; }
};

// The square is separable: first each pixel with its row neighbours, then each of those with its column neighbours.
template <typename Combine>
Mask combined_3x3(const Mask& mask, Combine combine) {
  const int width = mask.roi.width;
  const int height = mask.roi.height;
  const auto at = [width](int y) { return static_cast<std::size_t>(y) * static_cast<std::size_t>(width); };

  std::vector<std::uint8_t> rows(mask.pixels.size());
  for (int y = 0; y < height; ++y) {
    const std::uint8_t* in = mask.pixels.data() + at(y);
    std::uint8_t* out = rows.data() + at(y);
    std::copy_n(in, width, out);
    for (int x = 1; x < width; ++x) out[x] = combine(in[x], in[x - 1]);
    for (int x = 0; x + 1 < width; ++x) out[x] = combine(out[x], in[x + 1]);
  }

  Mask result{mask.roi, rows};
  for (int y = 0; y < height; ++y) {
    std::uint8_t* out = result.pixels.data() + at(y);
    for (const int neighbour : {y - 1, y + 1}) {
      if (neighbour < 0 || neighbour >= height) continue;
      const std::uint8_t* in = rows.data() + at(neighbour);
      for (int x = 0; x < width; ++x) out[x] = combine(out[x], in[x]);
    }
  }
  return result;
}

Mask cropped(const Mask& mask, const Roi& roi) {
  Mask result{roi, {}};
  result.pixels.reserve(static_cast<std::size_t>(roi.width) * static_cast<std::size_t>(roi.height));
  for (int y = roi.y; y < roi.bottom(); ++y) {
    const auto first =
        mask.pixels.begin() + static_cast<std::ptrdiff_t>(y - mask.roi.y) * mask.roi.width + (roi.x - mask.roi.x);
    result.pixels.insert(result.pixels.end(), first, first + roi.width);
  }
  return result;
}

}  // namespace

Mask eroded(const Mask& mask) {
  return combined_3x3(mask, And{});
}

Mask dilated(const Mask& mask) {
  return combined_3x3(mask, Or{});
}

Mask border_band(const Mask& mask, const Roi& box) {
  const Roi near{box.x - 2, box.y - 2, box.width + 4, box.height + 4};
  const Mask part = cropped(mask, intersection(near, mask.roi));
  Mask band = dilated(dilated(part));
  const Mask core = eroded(eroded(part));
  std::ranges::transform(band.pixels, core.pixels, band.pixels.begin(), [](std::uint8_t wide, std::uint8_t inner) {
    return static_cast<std::uint8_t>(wide & ~inner);
  });
  return band;
}

}  // namespace cylpose::serial
