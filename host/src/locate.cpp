#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <cylpose/locate.hpp>
#include <limits>
#include <optional>

#include "channels.hpp"
#include "linear_light.hpp"

namespace cylpose {
namespace {

constexpr int kUnit = 1 << 12;     // length of a unit normal
constexpr int kSubpixel = 1 << 8;  // offsets
constexpr int kReach = static_cast<int>(kLocateReach * kSubpixel);
constexpr int kRootBits = 8;  // by which light is shifted before its root is taken

// Distances from the edge pixel along the normal, in pixels. Gamma and shading put an edge pixel up to about 1.6 px
// inside of the border, blur of 2 px up to 3.
constexpr double kOutward = 4;        // hardly any of the part's light from here outward
constexpr double kInward = 3;         // all part from here inward
constexpr int kBackgroundPixels = 4;  // beyond, for the background's colour

// Weights for eight pixels of a line across the border, in one channel: their sum is positive outside of the border,
// zero on it and negative inside, whatever constant is added to the channel.
struct BorderFilter {
  int first;  // of the pixels, from the one where the filter stands
  std::array<int, 8> weights;
  int border;  // from the pixel where the filter stands when the sum is zero, in 1/kSubpixel
};

// For a channel that is 1 outside and 0 inside. The blurred step is odd about the border and the weights are even, so
// their sum is zero there whatever the blur and however far apart the two levels are. Longer weights would let in less
// noise, shorter ones less of a background that is not even.
constexpr BorderFilter kShareFilter{-4, {-2, -2, 1, 3, 3, 1, -2, -2}, -kSubpixel / 2};

// For a channel that is 0 outside and a + b * sqrt(depth) inside, with any a, b >= 0: an evenly lit surface, a limb, or
// both. Least squares: noise of 3 % of the light inside, and the sums at the border of 1, sqrt(depth) and, with a
// weight of 0.06, depth, over blurs of 0.45 to 1.25 px and all places of the border within a pixel.
constexpr BorderFilter kLimbFilter{-2, {131, -134, -100, 42, 112, 38, -29, -60}, -kSubpixel / 2};

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
  friend bool operator==(const Light&, const Light&) = default;
};

std::int64_t dot(const Light& a, const Light& b) {
  return a.r * b.r + a.g * b.g + a.b * b.b;
}

// What is perpendicular to `other` in `light`, times the square of `other`.
Light perpendicular(const Light& light, const Light& other) {
  const std::int64_t squared = dot(other, other);
  const std::int64_t along = dot(light, other);
  return {light.r * squared - along * other.r, light.g * squared - along * other.g,
          light.b * squared - along * other.b};
}

constexpr int kContrastCut = 16;  // bits of each component, so that the square fits

// The square of what perpendicular() gives, cut.
std::int64_t contrast(const Light& rest) {
  const Light cut{rest.r >> kContrastCut, rest.g >> kContrastCut, rest.b >> kContrastCut};
  return dot(cut, cut);
}

// The same direction with components of 13 bits and a sign, so that a product with light, summed over the colours, fits
// 32 bits.
Light narrowed(const Light& direction) {
  constexpr int kBits = 13;
  const std::int64_t largest = std::max({std::abs(direction.r), std::abs(direction.g), std::abs(direction.b)});
  const int surplus = std::max(static_cast<int>(std::bit_width(static_cast<std::uint64_t>(largest))) - kBits, 0);
  return {direction.r >> surplus, direction.g >> surplus, direction.b >> surplus};
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

// The same direction, of no negative component, with the largest one kUnit; zero as it is.
Light scaled_to_unit(const Light& direction) {
  const std::int64_t largest = std::max({direction.r, direction.g, direction.b, std::int64_t{1}});
  return {rounded_quotient(direction.r * kUnit, largest), rounded_quotient(direction.g * kUnit, largest),
          rounded_quotient(direction.b * kUnit, largest)};
}

bool has_normal(const EdgePixel& edge) {
  return edge.gx != 0 || edge.gy != 0;
}

// The row or column of pixels through an edge pixel, whichever is nearer to the normal, and the one on either side,
// moved along by whole pixels so that a straight border crosses all three near the same place. Sums over whole pixels
// are sums of light, so unlike interpolated samples they have no error of their own; a straight border that crosses the
// line `d` pixels from the edge pixel is d * cosine away along the normal.
class Line {
 public:
  // The gradient must not be zero.
  explicit Line(const EdgePixel& edge) : x_(edge.x), y_(edge.y) {
    const std::int64_t gx = edge.gx;
    const std::int64_t gy = edge.gy;
    constexpr std::int64_t kScale = 1 << 10;  // fraction bits of the gradient's length
    const std::int64_t length = integer_root((gx * gx + gy * gy) * kScale * kScale);
    along_row_ = std::abs(gx) >= std::abs(gy);
    const std::int64_t along = along_row_ ? gx : gy;
    const std::int64_t across = along_row_ ? gy : gx;
    step_ = along < 0 ? -1 : 1;
    if (2 * std::abs(across) > std::abs(along)) shift_ = across < 0 ? 1 : -1;
    cosine_ = rounded_quotient(std::abs(along) * kScale * kUnit, length);
  }

  // Column and row of the k-th pixel inward, on the line or (side = -1, 1) beside it.
  [[nodiscard]] int x(int k, int side = 0) const { return along_row_ ? x_ + (k + side * shift_) * step_ : x_ + side; }
  [[nodiscard]] int y(int k, int side = 0) const { return along_row_ ? y_ + side : y_ + (k + side * shift_) * step_; }

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
  bool along_row_;
  int step_;
  int shift_ = 0;        // of the line on side 1, in pixels inward; the one on side -1 goes the other way
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
  if (sum == Light{}) return std::nullopt;
  return scaled_to_unit(sum);
}

// The light along a line; it counts twice, and its neighbours once. (Where the border is curved, they pull the place
// in.)
class Profile {
 public:
  Profile(const LinearImage& image, const Line& line) {
    for (int k = kFirst; k <= kLast; ++k) {
      Light sum;
      for (const int side : {-1, 0, 0, 1}) sum += image.at(line.x(k, side), line.y(k, side));
      pixels_[index(k)] = {sum.r / 4, sum.g / 4, sum.b / 4};
    }
  }
  [[nodiscard]] const Light& operator[](int k) const { return pixels_[index(k)]; }

 private:
  [[nodiscard]] static std::size_t index(int k) { return static_cast<std::size_t>(k - kFirst); }

  // As far as anything below looks along a diagonal.
  static constexpr int kFirst = -11;
  static constexpr int kLast = 13;
  std::array<Light, kLast - kFirst + 1> pixels_;
};

// The light of a pixel in a channel, so that a filter's sum fits 32 bits.
std::int64_t level(const Light& pixel, const Light& channel) {
  constexpr int kCut = 9;
  return dot(pixel, channel) >> kCut;
}

// Where a function with these values at -1, 0, 1 and 2 is zero between 0 and 1, in 1/kSubpixel: the zero of the chord,
// moved by one Newton step on the cubic through all four. The chord alone is off by up to 0.02 px.
std::int64_t zero_between(std::int64_t before, std::int64_t here, std::int64_t next, std::int64_t beyond) {
  const std::int64_t drop = std::abs(here) + std::abs(next);
  const std::int64_t share = rounded_quotient(std::abs(here) * kSubpixel, drop);
  // The cubic less the chord is share (share - 1) (3 bend + (2 share - 1) twist) / 12, share counted in pixels.
  const std::int64_t bend = before - here - next + beyond;
  const std::int64_t twist = beyond - before + 3 * (here - next);
  constexpr std::int64_t kHalf = kSubpixel / 2;
  const std::int64_t excess = share * (share - kSubpixel) * (3 * kHalf * bend + (share - kHalf) * twist);
  constexpr std::int64_t kFarthest = kSubpixel / 8;  // where the cubic is far from straight it is not to be trusted
  const std::int64_t step = rounded_quotient(here > 0 ? excess : -excess, 12 * kHalf * kSubpixel * drop);
  return share + std::clamp(step, -kFarthest, kFarthest);
}

// Where the border crosses the line, in 1/kSubpixel from the edge pixel inward: the filter's sum goes from positive to
// negative there. Looked for from the pixel `start` on, at most `steps` pixels away.
std::optional<std::int64_t> crossing(const Profile& profile, const Light& channel, const BorderFilter& filter,
                                     int start, int steps) {
  const auto sum_at = [&](int k) {
    std::int64_t sum = 0;
    int pixel = k + filter.first;
    for (const int weight : filter.weights) sum += weight * level(profile[pixel++], channel);
    return sum;
  };
  std::int64_t here = sum_at(start);
  const bool inward = here > 0;
  const int step = inward ? 1 : -1;
  for (int k = start; k != start + steps * step; k += step) {
    const std::int64_t next = sum_at(k + step);
    if ((next > 0) != inward) {
      const std::int64_t share = zero_between(sum_at(k - step), here, next, sum_at(k + 2 * step));
      return std::int64_t{k} * kSubpixel + step * share + filter.border;
    }
    here = next;
  }
  return std::nullopt;
}

// The outside near a border: how much its levels differ, and how far it stands out from the inside (both over some
// pixels, so that only their ratio means something).
struct Outside {
  std::int64_t spread;
  std::int64_t height;
};

// `mirrored`: with the levels at equal distances inside added. Those of a blurred step before an even outside sum up to
// the same everywhere.
Outside outside_of(const Profile& profile, const Light& channel, int border, bool mirrored) {
  constexpr int kNearest = 2;  // pixels from the border
  constexpr int kFarthest = 6;
  std::int64_t lowest = std::numeric_limits<std::int64_t>::max();
  std::int64_t highest = std::numeric_limits<std::int64_t>::min();
  std::int64_t height = 0;
  for (int k = kNearest; k <= kFarthest; ++k) {
    const std::int64_t inside = level(profile[border + k], channel);
    const std::int64_t outside = level(profile[border - k], channel) + (mirrored ? inside : 0);
    lowest = std::min(lowest, outside);
    highest = std::max(highest, outside);
    height += mirrored ? outside : inside - outside;
  }
  return {highest - lowest, height};
}

// Whether the channel that tells outside from part stands a third as high on the part's side of a border, where the
// filter looks: something else begins there, and the sums are zero beside the border.
bool is_thin(const Profile& profile, const Light& channel, int border) {
  constexpr int kFirst = 3;  // pixels from the border, as far as the filter's outer weights
  constexpr int kLast = 4;
  std::int64_t inside = 0;
  std::int64_t outside = 0;
  for (int k = kFirst; k <= kLast; ++k) {
    inside += level(profile[border + k], channel);
    outside += level(profile[border - k], channel);
  }
  return 3 * std::abs(inside) > outside;
}

// Whether the light inside of a slope goes on to rise, by a third of what it is and straighter than toward any limb:
// there is a terminator inside of the border. (The square root of the depth rises by 0.9 and 0.6 from 1.5 to 4.5
// and 7.5.)
bool is_ramp(const Profile& profile, const Light& channel, int steepest) {
  const auto three_levels = [&](int k) {
    return level(profile[k], channel) + level(profile[k + 1], channel) + level(profile[k + 2], channel);
  };
  const std::int64_t near = three_levels(steepest);
  const std::int64_t middle = three_levels(steepest + 3);
  const std::int64_t far = three_levels(steepest + 6);
  const std::int64_t outside = 3 * level(profile[steepest - 3], channel);
  return 3 * (far - near) > near - outside && 8 * (2 * middle - near - far) < far - near;
}

// The pixel at most `reach` away that rises most above the one before it.
template <typename Value>
int steepest_of(const Value& value, int reach) {
  int steepest = -reach;
  for (int k = -reach + 1; k <= reach; ++k) {
    if (value(k) - value(k - 1) > value(steepest) - value(steepest - 1)) steepest = k;
  }
  return steepest;
}

// The vertex of the slope (parabola through three) whose largest is the rise to pixel k, in 1/kSubpixel; none where
// that is not the largest.
template <typename Value>
std::optional<std::int64_t> vertex_of(const Value& value, int k) {
  const std::int64_t before = value(k - 1) - value(k - 2);
  const std::int64_t peak = value(k) - value(k - 1);
  const std::int64_t after = value(k + 1) - value(k);
  if (before > peak || after > peak || 2 * peak == before + after) return std::nullopt;
  return std::int64_t{k} * kSubpixel - kSubpixel / 2 +
         rounded_quotient((after - before) * (kSubpixel / 2), 2 * peak - before - after);
}

struct Place {
  std::int64_t offset;  // along the normal, in 1/kSubpixel
  EdgeCue cue;
};

// By a channel that is zero outside. The limb filter's sum has more zeros than one, so it starts from the largest
// slope, which lies at most a pixel inside of the border. Where there is no zero near by, or a terminator makes the
// light fall off otherwise, the vertex of the slope is taken. Where that lies deep inside, it is the terminator's: then
// the root of the light tells where it begins, to half a pixel, be that a step, a ramp or both. Zero where the light
// does not rise inward.
Place place_by_limb(const Profile& profile, const Line& line, const Light& channel) {
  constexpr int kSteps = 2;
  constexpr int kDeep = 3 * kSubpixel / 2;  // farther apart than a blur of 1.5 px makes the vertices at a step
  const int reach = line.pixels(kLocateReach);
  const auto light = [&](int k) { return level(profile[k], channel); };
  const int steepest = steepest_of(light, reach);
  if (light(steepest) <= light(steepest - 1)) return {0, EdgeCue::kNone};
  std::optional<std::int64_t> border;
  if (!is_ramp(profile, channel, steepest)) border = crossing(profile, channel, kLimbFilter, steepest, kSteps);
  EdgeCue cue = EdgeCue::kLimb;
  if (!border) {
    cue = EdgeCue::kSlope;
    const auto root = [&](int k) { return integer_root(std::max<std::int64_t>(0, light(k)) << kRootBits); };
    border = vertex_of(light, steepest);
    const std::optional<std::int64_t> beginning = vertex_of(root, steepest_of(root, reach));
    if (beginning && (!border || *border - *beginning > kDeep)) border = beginning;
  }
  if (!border) return {0, EdgeCue::kNone};
  const std::int64_t offset = line.to_normal(*border);
  if (std::abs(offset) > kReach) return {0, EdgeCue::kNone};
  return {offset, cue};
}

// By the outside's share b = w.pixel, w being the outside's colour (a sum over kBackgroundPixels) without its share
// along the part's. None where the outside is too dark or too near the part's hue for that, or the border is out of
// reach.
//
// Where the outside is not even, w.pixel tells its texture instead. The roles are turned then: the part's colour
// without its share along the outside's is zero outside, however bright that is, and its border that of a limb before
// black.
std::optional<Place> place_between(const Profile& profile, const Line& line, const Light& outside, const Light& color) {
  // The least distance of the outside from the part's line of colours, in units of light: that of a grey of code 11
  // from a pure hue. There noise of sigma 1.5 moves a point by as much as before black.
  constexpr std::int64_t kLeastContrast = 300;
  const std::int64_t least = kLeastContrast * kBackgroundPixels * (dot(color, color) >> kContrastCut);
  const Light rest = perpendicular(outside, color);
  if (contrast(rest) < least * least) return std::nullopt;

  const Light channel = narrowed(rest);
  const std::optional<std::int64_t> border = crossing(profile, channel, kShareFilter, 0, line.pixels(kLocateReach));
  if (!border || std::abs(line.to_normal(*border)) > kReach) return std::nullopt;

  const auto middle = static_cast<int>(rounded_quotient(*border, kSubpixel));
  const Outside share = outside_of(profile, channel, middle, true);
  constexpr int kEven = 25;  // times the spread must not be above the height: a fifth of one pixel's level
  if (kEven * share.spread > share.height) {
    if (is_thin(profile, channel, middle)) return Place{line.to_normal(*border), EdgeCue::kNone};
    const Light turned = narrowed(perpendicular(color, outside));
    const Outside part = outside_of(profile, turned, middle, false);
    // Twice as even, or shading costs more than it saves.
    if (2 * part.spread * share.height <= share.spread * part.height) return place_by_limb(profile, line, turned);
  }
  return Place{line.to_normal(*border), EdgeCue::kShare};
}

// A direction without the colours in which the outside is so bright that the sensor cuts it off.
Light unclipped(const Light& direction, const Light& outside) {
  constexpr std::int64_t kMost = kBackgroundPixels * 65535 * 99 / 100;  // code 254: JPEG moves codes a little
  return {outside.r > kMost ? 0 : direction.r, outside.g > kMost ? 0 : direction.g,
          outside.b > kMost ? 0 : direction.b};
}

// Where the sensor cuts the outside's light off, nobody knows how bright it is, and the half of what is left of it lies
// inside of the border. The other colours tell better, where part and outside differ by a fourth as much in them.
std::optional<Place> place_by_share(const Profile& profile, const Line& line, const Light& color) {
  Light outside;
  for (int k = 1; k <= kBackgroundPixels; ++k) outside += profile[-line.pixels(kOutward) - k];
  const Light rest = unclipped(outside, outside);
  if (rest == outside) return place_between(profile, line, outside, color);
  const Light color_there = scaled_to_unit(unclipped(color, outside));
  if (16 * contrast(perpendicular(rest, color_there)) >= contrast(perpendicular(outside, color))) {
    if (const auto place = place_between(profile, line, rest, color_there)) return place;
  }
  std::optional<Place> place = place_between(profile, line, outside, color);
  if (place) place->cue = EdgeCue::kClipped;
  return place;
}

}  // namespace

void locate_edges(const ImageView& image, const Roi& search, const ColorGate& gate, Transfer transfer,
                  std::vector<EdgePixel>& edges) {
  const LinearImage light(image, search, transfer);
  const std::optional<Light> color = part_color(image, light, gate, edges);
  for (EdgePixel& edge : edges) {
    edge.offset_256 = 0;
    edge.cue = EdgeCue::kNone;
    if (!has_normal(edge)) continue;
    const Line line(edge);
    const Profile profile(light, line);
    std::optional<Place> place = color ? place_by_share(profile, line, *color) : std::nullopt;
    if (!place) place = place_by_limb(profile, line, color.value_or(Light{kUnit, kUnit, kUnit}));
    edge.offset_256 = static_cast<std::int16_t>(place->offset);
    edge.cue = place->cue;
  }
}

}  // namespace cylpose
