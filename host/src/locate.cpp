#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <cylpose/locate.hpp>
#include <optional>

#include "channels.hpp"
#include "linear_light.hpp"

namespace cylpose {
namespace {

// Distances along the normal, in pixels. Gamma and shading put an edge pixel up to about 1.6 px inside the border and
// hardly outside it; a lens blur of sigma 0.7 and the pixel itself mix light from less than kBlur away.
constexpr double kOutward = 4;        // from the edge pixel: all background from here outward
constexpr double kInward = 3;         // from the edge pixel: all part from here inward
constexpr double kBlur = 2;           // from the border: hardly any mixed light farther away
constexpr int kBackgroundPixels = 4;  // beyond, for the background's colour

constexpr int kUnit = 1 << 12;     // length of a unit normal
constexpr int kSubpixel = 1 << 8;  // offsets
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

// Floor of the square root of a value below 2^62.
std::int64_t integer_root(std::int64_t value) {
  std::int64_t root = 0;
  for (std::int64_t bit = std::int64_t{1} << 30; bit != 0; bit >>= 1) {
    if ((root + bit) * (root + bit) <= value) root += bit;
  }
  return root;
}

// To the nearest, halves away from zero; `denominator` > 0.
std::int64_t rounded_quotient(std::int64_t numerator, std::int64_t denominator) {
  return (numerator >= 0 ? numerator + denominator / 2 : numerator - denominator / 2) / denominator;
}

bool has_normal(const EdgePixel& edge) {
  return edge.gx != 0 || edge.gy != 0;
}

// The row or column of pixels through an edge pixel, whichever is nearer to the normal. Sums over whole pixels are sums
// of light, so unlike interpolated samples they have no error of their own; a straight border that crosses the line
// `d` pixels from the edge pixel is d * cosine away along the normal.
class Line {
 public:
  // The gradient must not be zero.
  explicit Line(const EdgePixel& edge) : x_(edge.x), y_(edge.y) {
    const std::int64_t gx = edge.gx;
    const std::int64_t gy = edge.gy;
    constexpr std::int64_t kScale = 1 << 10;  // fraction bits of the gradient's length
    const std::int64_t length = integer_root((gx * gx + gy * gy) * kScale * kScale);
    const bool along_row = std::abs(gx) >= std::abs(gy);
    const std::int64_t along = along_row ? gx : gy;
    (along_row ? step_x_ : step_y_) = along < 0 ? -1 : 1;
    cosine_ = rounded_quotient(std::abs(along) * kScale * kUnit, length);
  }

  // Column and row of the k-th pixel inward.
  [[nodiscard]] int x(int k) const { return x_ + k * step_x_; }
  [[nodiscard]] int y(int k) const { return y_ + k * step_y_; }

  // Pixels along the line that reach so far along the normal.
  [[nodiscard]] int pixels(double along_normal) const {
    return static_cast<int>(rounded_quotient(static_cast<std::int64_t>(along_normal * kUnit), cosine_));
  }

  // From a distance along the line to one along the normal.
  [[nodiscard]] std::int64_t to_normal(std::int64_t distance) const {
    return rounded_quotient(distance * cosine_, kUnit);
  }

 private:
  int x_;
  int y_;
  int step_x_ = 0;
  int step_y_ = 0;
  std::int64_t cosine_;  // between line and normal, in 1/kUnit
};

class LinearImage {
 public:
  LinearImage(const ImageView& image, const Roi& search, Transfer transfer)
      : image_(image), search_(search), table_(linear_light(transfer)), channel_(channels_of(image.format)) {}

  [[nodiscard]] Light at(int x, int y) const {
    const std::uint8_t* codes = pixel(x, y);
    return {table_[codes[channel_.red]], table_[codes[channel_.green]], table_[codes[channel_.blue]]};
  }

  // Whether a pixel may tell the part's colour: it is in the gate and not clipped, which would change its colour.
  [[nodiscard]] bool shows_part(int x, int y, const ColorGate& gate) const {
    const std::uint8_t* codes = pixel(x, y);
    const int r = codes[channel_.red];
    const int g = codes[channel_.green];
    const int b = codes[channel_.blue];
    return passes(gate, r, g, b) && std::max({r, g, b}) < 255;
  }

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

// The light along a line, as far as any of the windows below reaches.
class Profile {
 public:
  Profile(const LinearImage& light, const Line& line)
      : first_(-std::max(line.pixels(kOutward), recentred(line)) - kBackgroundPixels) {
    const int last = std::max(line.pixels(kInward), recentred(line));
    for (int k = first_; k <= last; ++k) pixels_[index(k)] = light.at(line.x(k), line.y(k));
  }
  [[nodiscard]] const Light& operator[](int k) const { return pixels_[index(k)]; }

 private:
  // How far a window around a border that is just in reach goes; one more, as places are rounded to whole pixels.
  [[nodiscard]] static int recentred(const Line& line) { return line.pixels(kLocateReach) + 1 + line.pixels(kBlur); }
  [[nodiscard]] std::size_t index(int k) const { return static_cast<std::size_t>(k - first_); }

  static constexpr double kDiagonal = 1.4143;  // how much longer than the normal a line can be
  static constexpr int kFarthest = static_cast<int>(kDiagonal * (kLocateReach + kBlur)) + 3;
  static_assert(kFarthest >= kDiagonal * kOutward + 1 && kFarthest >= kDiagonal * kInward + 1);

  int first_;
  std::array<Light, 2 * kFarthest + kBackgroundPixels + 1> pixels_;
};

// The part's colour direction, largest component kUnit: mean over the inner sides of the strong edges (weak ones are
// often a background's). None in a grey image, or where no pixel shows the colour.
std::optional<Light> part_color(const ImageView& image, const LinearImage& light, const ColorGate& gate,
                                const std::vector<EdgePixel>& edges) {
  if (image.format == PixelFormat::kGray8) return std::nullopt;
  Light sum;
  for (const EdgePixel& edge : edges) {
    if (!has_normal(edge) || edge.strength != EdgeStrength::kStrong) continue;
    const Line line(edge);
    for (const int k : {line.pixels(kInward), line.pixels(kInward) + 1}) {
      if (light.shows_part(line.x(k), line.y(k), gate)) sum += light.at(line.x(k), line.y(k));
    }
  }
  const std::int64_t largest = std::max({sum.r, sum.g, sum.b});
  if (largest == 0) return std::nullopt;
  return Light{rounded_quotient(sum.r * kUnit, largest), rounded_quotient(sum.g * kUnit, largest),
               rounded_quotient(sum.b * kUnit, largest)};
}

// Where the outside ends on the line, in 1/kSubpixel from the edge pixel inward, judged from the pixels that lie at
// most `outward` before and `inward` behind the pixel `middle`; the kBackgroundPixels beyond give the background. None
// where that is too dark or too near the part's hue to tell them apart.
std::optional<std::int64_t> crossing_by_share(const Profile& profile, const Light& color, int middle, int outward,
                                              int inward) {
  const int first = middle - outward;
  Light outside;  // kBackgroundPixels times B
  for (int k = 1; k <= kBackgroundPixels; ++k) outside += profile[first - k];

  // B without its share along c, in 1/kFraction of a light unit, so that rounding leaves w orthogonal to c.
  constexpr std::int64_t kFraction = 64;
  const std::int64_t color_squared = dot(color, color);
  const std::int64_t along = dot(outside, color);
  const auto orthogonal = [&](std::int64_t of_outside, std::int64_t of_color) {
    return rounded_quotient((of_outside * color_squared - along * of_color) * kFraction,
                            color_squared * kBackgroundPixels);
  };
  const Light w{orthogonal(outside.r, color.r), orthogonal(outside.g, color.g), orthogonal(outside.b, color.b)};

  // The least distance of B from the part's line of colours, in units of light: that of a grey of code 11 from a pure
  // hue. There noise of sigma 1.5 moves a single point by 0.4 px; below, the slope does better with all its bias.
  constexpr std::int64_t kLeastContrast = 300;
  if (dot(w, w) < kLeastContrast * kLeastContrast * kFraction * kFraction) return std::nullopt;

  const std::int64_t full = dot(w, outside) / kBackgroundPixels;  // w.B
  std::int64_t sum = 0;
  for (int k = first; k <= middle + inward; ++k) {
    // Anything else within the window may pull no further than this.
    sum += std::clamp(dot(w, profile[k]), -full / 2, full + full / 2);
  }
  // The window begins half a pixel before its first pixel's centre.
  return first * kSubpixel - kSubpixel / 2 + rounded_quotient(sum * kSubpixel, full);
}

// Offset by the share of the outside: once with a window that holds the border wherever it may be, and again with a
// narrow one around that place, which lets in less noise. None where there is no such share or the border is out of
// reach.
std::optional<std::int64_t> offset_by_share(const Profile& profile, const Line& line, const Light& color) {
  const auto in_reach = [&](const std::optional<std::int64_t>& crossing) {
    return crossing && std::abs(line.to_normal(*crossing)) <= kReach;
  };
  const auto coarse = crossing_by_share(profile, color, 0, line.pixels(kOutward), line.pixels(kInward));
  if (!in_reach(coarse)) return std::nullopt;
  const auto middle = static_cast<int>(rounded_quotient(*coarse, kSubpixel));
  const int half = line.pixels(kBlur);
  const auto fine = crossing_by_share(profile, color, middle, half, half);
  if (!in_reach(fine)) return std::nullopt;
  return line.to_normal(*fine);
}

// Offset of the largest slope of the light: vertex of the parabola through it and its two neighbours. Zero where the
// light does not rise inward or has its largest slope at the end of what is in reach.
std::int64_t offset_by_slope(const Profile& profile, const Line& line, const std::optional<Light>& color) {
  const Light direction = color.value_or(Light{kUnit, kUnit, kUnit});
  const auto slope = [&](int k) {  // between pixels k - 1 and k, that is at k - 1/2
    return dot(profile[k], direction) - dot(profile[k - 1], direction);
  };
  const int innermost = line.pixels(kInward) - 1;
  int best = -innermost;
  for (int k = best + 1; k <= innermost; ++k) {
    if (slope(k) > slope(best)) best = k;
  }
  const std::int64_t before = slope(best - 1);
  const std::int64_t peak = slope(best);
  const std::int64_t after = slope(best + 1);
  const std::int64_t curvature = 2 * peak - before - after;
  if (peak <= 0 || before > peak || after > peak || curvature == 0) return 0;
  const std::int64_t vertex = rounded_quotient((after - before) * (kSubpixel / 2), curvature);
  const std::int64_t offset = line.to_normal(best * kSubpixel - kSubpixel / 2 + vertex);
  return std::abs(offset) > kReach ? 0 : offset;
}

}  // namespace

void locate_edges(const ImageView& image, const Roi& search, const ColorGate& gate, Transfer transfer,
                  std::vector<EdgePixel>& edges) {
  const LinearImage light(image, search, transfer);
  const std::optional<Light> color = part_color(image, light, gate, edges);
  for (EdgePixel& edge : edges) {
    edge.offset_256 = 0;
    if (!has_normal(edge)) continue;
    const Line line(edge);
    const Profile profile(light, line);
    const std::optional<std::int64_t> offset = color ? offset_by_share(profile, line, *color) : std::nullopt;
    edge.offset_256 = static_cast<std::int16_t>(offset ? *offset : offset_by_slope(profile, line, color));
  }
}

}  // namespace cylpose
