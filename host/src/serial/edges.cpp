#include "serial/edges.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdlib>

#include "channels.hpp"

namespace cylpose::serial {
namespace {

struct Gradient {
  int x;
  int y;
  [[nodiscard]] int squared() const { return x * x + y * y; }
};

// The response around a rectangle, and its gradient there.
class ResponseImage {
 public:
  ResponseImage(const ImageView& image, const Roi& search, const ColorGate& gate, const Roi& around)
      : search_(search),
        origin_x_(around.x - kMargin),
        origin_y_(around.y - kMargin),
        stride_(around.width + 2 * kMargin) {
    const int rows = around.height + 2 * kMargin;
    values_.resize(static_cast<std::size_t>(stride_) * static_cast<std::size_t>(rows));
    // The margin's pixels that are not in `search` repeat the nearest one that is.
    const int first_x = std::max(origin_x_, search.x);
    const int end_x = std::min(origin_x_ + stride_, search.right());
    const Channels channel = channels_of(image.format);
    std::uint8_t* out = values_.data();
    for (int y = 0; y < rows; ++y, out += stride_) {
      const std::uint8_t* pixel = image.row(std::clamp(origin_y_ + y, search.y, search.bottom() - 1)) +
                                  static_cast<std::ptrdiff_t>(first_x) * channel.step;
      std::uint8_t* const first = out + (first_x - origin_x_);
      std::uint8_t* const end = out + (end_x - origin_x_);
      if (image.format == PixelFormat::kGray8) {
        std::copy_n(pixel, end - first, first);
      } else {
        for (std::uint8_t* value = first; value != end; ++value, pixel += channel.step) {
          *value =
              static_cast<std::uint8_t>(response(gate, pixel[channel.red], pixel[channel.green], pixel[channel.blue]));
        }
      }
      std::fill(out, first, *first);
      std::fill(end, out + stride_, *(end - 1));
    }
  }

  // At a pixel of `around` or a neighbour of one.
  [[nodiscard]] Gradient gradient(int x, int y) const {
    if (!search_.contains(x, y)) return {0, 0};
    const std::uint8_t* mid = values_.data() + static_cast<std::ptrdiff_t>(y - origin_y_) * stride_ + (x - origin_x_);
    const std::uint8_t* up = mid - stride_;
    const std::uint8_t* down = mid + stride_;
    return {(up[1] - up[-1]) + 2 * (mid[1] - mid[-1]) + (down[1] - down[-1]),
            (down[-1] - up[-1]) + 2 * (down[0] - up[0]) + (down[1] - up[1])};
  }

 private:
  static constexpr int kMargin = 2;  // one for the neighbours in the suppression, one for their Sobel

  Roi search_;
  int origin_x_;
  int origin_y_;
  int stride_;
  std::vector<std::uint8_t> values_;
};

struct Step {
  int x;
  int y;
};

// From a pixel to the neighbour in the gradient's direction, to the nearest of eight.
Step step_along(const Gradient& g) {
  constexpr int kTan22 = 13573;  // tan(22.5 deg) in 1/2^15
  constexpr int kOne = 1 << 15;
  const int ax = std::abs(g.x);
  const int ay = std::abs(g.y);
  const int sign_x = g.x < 0 ? -1 : 1;
  const int sign_y = g.y < 0 ? -1 : 1;
  if (ay * kOne < ax * kTan22) return {sign_x, 0};
  if (ay * kOne > ax * (kTan22 + 2 * kOne)) return {0, sign_y};  // tan(67.5 deg) = tan(22.5 deg) + 2
  return {sign_x, sign_y};
}

constexpr int squared_sobel(int levels_per_pixel) {
  return 64 * levels_per_pixel * levels_per_pixel;
}

}  // namespace

std::vector<EdgePixel> find_edges(const ImageView& image, const Roi& search, const ColorGate& gate, const Mask& band,
                                  const DetectOptions& options) {
  const ResponseImage response_image(image, search, gate, band.roi);
  const int weak = squared_sobel(options.edge_low);
  const int strong = squared_sobel(options.edge_high);

  std::vector<EdgePixel> edges;
  const std::uint8_t* in_band = band.pixels.data();
  for (int y = band.roi.y; y < band.roi.bottom(); ++y) {
    for (int x = band.roi.x; x < band.roi.right(); ++x) {
      if (*in_band++ == 0) continue;
      const Gradient here = response_image.gradient(x, y);
      const int magnitude = here.squared();
      if (magnitude < weak) continue;
      const Step step = step_along(here);
      if (magnitude <= response_image.gradient(x + step.x, y + step.y).squared() ||
          magnitude < response_image.gradient(x - step.x, y - step.y).squared()) {
        continue;
      }
      edges.push_back({static_cast<std::int16_t>(x), static_cast<std::int16_t>(y), static_cast<std::int16_t>(here.x),
                       static_cast<std::int16_t>(here.y), 0,
                       magnitude >= strong ? EdgeStrength::kStrong : EdgeStrength::kWeak});
    }
  }
  return edges;
}

}  // namespace cylpose::serial
