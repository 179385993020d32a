#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cylpose/locate.hpp>
#include <optional>

#include "channels.hpp"
#include "linear_light.hpp"

namespace cylpose {
namespace {

// Samples along the normal, one pixel apart. Codes lie at most about 1 px beside the border (half a pixel of grid, the
// rest from gamma and shading) and blur reaches 2 px farther, so from kOutside outward all is background and kInside
// is all part.
constexpr int kFar = -6;      // outermost sample
constexpr int kOutside = -4;  // innermost of the samples that give the background's colour
constexpr int kInside = 4;    // innermost sample of the part
constexpr int kSamples = kInside - kFar + 1;

constexpr int kUnit = 1 << 12;     // length of a unit normal
constexpr int kSubpixel = 1 << 8;  // pixel positions and offsets
constexpr int kReach = static_cast<int>(kLocateReach * kSubpixel);

// Light, 65535 for code 255; or any vector in that space.
struct Light {
  std::int64_t r = 0;
  std::int64_t g = 0;
  std::int64_t b = 0;

  Light& operator+=(const Light& other) {
    r += other.r;
    g += other.g;
    b += other.b;
    return *this;
  }
};

std::int64_t dot(const Light& a, const Light& b) {
  return a.r * b.r + a.g * b.g + a.b * b.b;
}

// Floor of the square root.
std::int64_t integer_root(std::int64_t value) {
  std::int64_t root = 0;
  for (std::int64_t bit = std::int64_t{1} << 30; bit != 0; bit >>= 1) {
    if ((root + bit) * (root + bit) <= value) root += bit;
  }
  return root;
}

std::int64_t rounded_quotient(std::int64_t numerator, std::int64_t positive) {
  return (numerator >= 0 ? numerator + positive / 2 : numerator - positive / 2) / positive;
}

struct Normal {
  int x;  // in 1/kUnit
  int y;
};

Normal unit_normal(const EdgePixel& edge) {
  const std::int64_t gx = edge.gx;
  const std::int64_t gy = edge.gy;
  constexpr std::int64_t kScale = 1 << 10;
  const std::int64_t length = integer_root((gx * gx + gy * gy) * kScale * kScale);
  return {static_cast<int>(rounded_quotient(gx * kScale * kUnit, length)),
          static_cast<int>(rounded_quotient(gy * kScale * kUnit, length))};
}

class LinearImage {
 public:
  LinearImage(const ImageView& image, const Roi& search, Transfer transfer)
      : image_(image), search_(search), table_(linear_light(transfer)), channel_(channels_of(image.format)) {}

  // Bilinear at a position in 1/kSubpixel.
  [[nodiscard]] Light at(int x, int y) const {
    const int column = x >> 8;
    const int row = y >> 8;
    const auto fx = static_cast<std::uint32_t>(x & (kSubpixel - 1));
    const auto fy = static_cast<std::uint32_t>(y & (kSubpixel - 1));
    const std::uint8_t* p00 = pixel(column, row);
    const std::uint8_t* p10 = pixel(column + 1, row);
    const std::uint8_t* p01 = pixel(column, row + 1);
    const std::uint8_t* p11 = pixel(column + 1, row + 1);
    // 16 bits of light times 16 bits of weights that sum to 2^16: just fits.
    const auto mixed = [&](int channel) {
      const std::uint32_t upper = table_[p00[channel]] * (kSubpixel - fx) + table_[p10[channel]] * fx;
      const std::uint32_t lower = table_[p01[channel]] * (kSubpixel - fx) + table_[p11[channel]] * fx;
      return static_cast<std::int64_t>(
          (static_cast<std::uint64_t>(upper) * (kSubpixel - fy) + static_cast<std::uint64_t>(lower) * fy) >> 16);
    };
    return {mixed(channel_.red), mixed(channel_.green), mixed(channel_.blue)};
  }

  // The pixel nearest to a position in 1/kSubpixel.
  [[nodiscard]] const std::uint8_t* nearest(int x, int y) const {
    return pixel((x + kSubpixel / 2) >> 8, (y + kSubpixel / 2) >> 8);
  }

  [[nodiscard]] const LinearTable& table() const { return table_; }
  [[nodiscard]] const Channels& channels() const { return channel_; }

 private:
  [[nodiscard]] const std::uint8_t* pixel(int x, int y) const {
    return image_.row(std::clamp(y, search_.y, search_.bottom() - 1)) +
           static_cast<std::ptrdiff_t>(std::clamp(x, search_.x, search_.right() - 1)) * channel_.step;
  }

  ImageView image_;
  Roi search_;
  const LinearTable& table_;
  Channels channel_;
};

using Profile = std::array<Light, kSamples>;

constexpr std::size_t index_of(int sample) {
  return static_cast<std::size_t>(sample - kFar);
}

int place(int pixel, int normal, int sample) {
  return pixel * kSubpixel + normal * sample * kSubpixel / kUnit;
}

Profile profile_of(const LinearImage& light, const EdgePixel& edge, const Normal& normal) {
  Profile profile;
  for (int k = kFar; k <= kInside; ++k) {
    profile[index_of(k)] = light.at(place(edge.x, normal.x, k), place(edge.y, normal.y, k));
  }
  return profile;
}

// The part's colour direction, largest component kUnit: mean of the pixels on the edges' inner sides that have the
// part's colour, without clipped ones, which have another. None in a grey image, or where no such pixel is left.
std::optional<Light> part_color(const ImageView& image, const LinearImage& light, const ColorGate& gate,
                                const std::vector<EdgePixel>& edges) {
  if (image.format == PixelFormat::kGray8) return std::nullopt;
  Light sum;
  for (const EdgePixel& edge : edges) {
    const Normal normal = unit_normal(edge);
    for (const int k : {kInside - 1, kInside}) {
      const std::uint8_t* pixel = light.nearest(place(edge.x, normal.x, k), place(edge.y, normal.y, k));
      const int r = pixel[light.channels().red];
      const int g = pixel[light.channels().green];
      const int b = pixel[light.channels().blue];
      if (!passes(gate, r, g, b) || std::max({r, g, b}) == 255) continue;
      sum += {light.table()[static_cast<std::size_t>(r)], light.table()[static_cast<std::size_t>(g)],
              light.table()[static_cast<std::size_t>(b)]};
    }
  }
  const std::int64_t largest = std::max({sum.r, sum.g, sum.b});
  if (largest == 0) return std::nullopt;
  return Light{rounded_quotient(sum.r * kUnit, largest), rounded_quotient(sum.g * kUnit, largest),
               rounded_quotient(sum.b * kUnit, largest)};
}

// Offset by the share of the outside. None where the outside is too dark or too near the part's hue to tell them apart,
// or the border is out of reach.
std::optional<int> offset_by_share(const Profile& profile, const Light& color) {
  constexpr int kBackgroundSamples = kOutside - kFar + 1;
  Light outside;  // kBackgroundSamples times B
  for (int k = kFar; k <= kOutside; ++k) outside += profile[index_of(k)];

  // B without its share along c, in 1/kFraction of a light unit, so that rounding leaves w orthogonal to c.
  constexpr std::int64_t kFraction = 64;
  const std::int64_t color_squared = dot(color, color);
  const std::int64_t along = dot(outside, color);
  const auto orthogonal = [&](std::int64_t part_of_outside, std::int64_t part_of_color) {
    return rounded_quotient((part_of_outside * color_squared - along * part_of_color) * kFraction,
                            color_squared * kBackgroundSamples);
  };
  const Light w{orthogonal(outside.r, color.r), orthogonal(outside.g, color.g), orthogonal(outside.b, color.b)};

  // The least distance of B from the part's line of colours, in units of light: about that of code 38 from black.
  constexpr std::int64_t kLeastContrast = 1300;
  if (dot(w, w) < kLeastContrast * kLeastContrast * kFraction * kFraction) return std::nullopt;

  const std::int64_t full = dot(w, outside) / kBackgroundSamples;  // w.B
  std::int64_t sum = 0;
  for (int k = kOutside; k <= kInside; ++k) {
    // Anything else within the window may pull no further than this.
    sum += std::clamp(dot(w, profile[index_of(k)]), -full / 2, full + full / 2);
  }
  // Each sample stands for one pixel, the first from kOutside - 1/2 on.
  const std::int64_t offset = rounded_quotient(sum * kSubpixel, full) + (2 * kOutside - 1) * kSubpixel / 2;
  if (offset < -kReach || offset > kReach) return std::nullopt;
  return static_cast<int>(offset);
}

// Offset of the largest slope along the normal: vertex of the parabola through it and its two neighbours.
int offset_by_slope(const Profile& profile, const std::optional<Light>& color) {
  const Light direction = color.value_or(Light{kUnit, kUnit, kUnit});
  const auto slope = [&](int k) {  // between samples k - 1 and k, that is at k - 1/2
    return dot(profile[index_of(k)], direction) - dot(profile[index_of(k - 1)], direction);
  };
  int best = -1;
  for (int k = -1; k <= 2; ++k) {
    if (slope(k) > slope(best)) best = k;
  }
  const std::int64_t before = slope(best - 1);
  const std::int64_t peak = slope(best);
  const std::int64_t after = slope(best + 1);
  if (peak <= 0 || before > peak || after > peak) return 0;
  const std::int64_t curvature = 2 * peak - before - after;
  const std::int64_t vertex = curvature > 0 ? rounded_quotient((after - before) * (kSubpixel / 2), curvature) : 0;
  return best * kSubpixel - kSubpixel / 2 + static_cast<int>(vertex);
}

}  // namespace

void locate_edges(const ImageView& image, const Roi& search, const ColorGate& gate, Transfer transfer,
                  std::vector<EdgePixel>& edges) {
  const LinearImage light(image, search, transfer);
  const std::optional<Light> color = part_color(image, light, gate, edges);
  for (EdgePixel& edge : edges) {
    const Profile profile = profile_of(light, edge, unit_normal(edge));
    const std::optional<int> offset = color ? offset_by_share(profile, *color) : std::nullopt;
    edge.offset_256 = static_cast<std::int16_t>(offset ? *offset : offset_by_slope(profile, color));
  }
}

}  // namespace cylpose
