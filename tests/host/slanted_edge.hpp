// Pictures of one straight border of a part with the truth known exactly, to measure how well edges are located.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cylpose/edge_field.hpp>
#include <cylpose/image.hpp>
#include <numbers>
#include <random>
#include <vector>

namespace cylpose::testing {

using Rgb = std::array<double, 3>;  // linear light, 0..1

/// Of a code 0..255.
inline double light_of_code(double code) {
  const double c = code / 255;
  return c <= 0.04045 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4);
}

inline double code_of_light(double light) {
  return 255 * (light <= 0.0031308 ? 12.92 * light : 1.055 * std::pow(light, 1 / 2.4) - 0.055);
}

inline Rgb light_of_codes(double r, double g, double b) {
  return {light_of_code(r), light_of_code(g), light_of_code(b)};
}

struct SlantedEdge {
  Rgb part = light_of_codes(200, 40, 40);  ///< where it is lit best
  Rgb background = light_of_codes(120, 120, 120);
  Rgb second = {};        ///< waves of it in the background,
  double texture_px = 0;  ///< this long in several directions; 0: none
  double angle_rad = 0;   ///< of the inward normal, from +x toward +y
  double phase = 0;       ///< the border passes this far inside of the picture's middle pixel
  double limb_px = 40;    ///< radius of the cylinder seen from the side, for the falloff of light; 0: evenly lit
  double ambient = 0.25;  ///< share of the light that does not fall off
  double light_rad = 0;   ///< direction of the light that does: 0 from the camera, positive from outside of the border
  double blur_px = 0.7;   ///< sigma of the lens
  double box_px = 0;      ///< width of another blur, a box
  double noise = 1.5;     ///< sigma in codes
  bool linear_codes = false;
  bool gray = false;  ///< one channel, the mean of the three lights
  unsigned seed = 1;
  int size = 96;  ///< columns and rows

  /// Signed distance of a point from the border, positive inside.
  [[nodiscard]] double inside(double x, double y) const {
    const double middle = size / 2;  // a whole pixel
    return (x - middle) * std::cos(angle_rad) + (y - middle) * std::sin(angle_rad) - phase;
  }
};

/// The picture: the scene depends on the distance from the border only, so its profile, blurred by the lens and by the
/// pixel's square aperture, is integrated once on a fine grid and looked up per pixel.
class SlantedEdgePicture {
 public:
  explicit SlantedEdgePicture(const SlantedEdge& edge) : edge_(edge) {
    const std::vector<double> kernel = aperture();
    const int half = static_cast<int>(kernel.size() / 2);
    std::vector<Share> scene;
    for (int i = -kReach * kFine - half; i <= kReach * kFine + half; ++i) scene.push_back(share_at((i + 0.5) / kFine));
    profile_.resize(static_cast<std::size_t>(2 * kReach * kFine));
    for (std::size_t i = 0; i < profile_.size(); ++i) {
      for (std::size_t k = 0; k < kernel.size(); ++k) {
        profile_[i].part += kernel[k] * scene[i + k].part;
        profile_[i].outside += kernel[k] * scene[i + k].outside;
      }
    }
    std::mt19937 random(edge.seed);
    std::normal_distribution<double> noise(0, 1);
    for (int y = 0; y < edge.size; ++y) {
      for (int x = 0; x < edge.size; ++x) {
        const Rgb light = this->light(x, y);
        if (edge.gray) {
          put((light[0] + light[1] + light[2]) / 3, edge.noise * noise(random));
        } else {
          for (const std::size_t c : {2U, 1U, 0U}) put(light[c], edge.noise * noise(random));
        }
      }
    }
  }

  /// What falls on a pixel, without noise.
  [[nodiscard]] Rgb light(int x, int y) const { return mixed(blurred(edge_.inside(x, y)), background(x, y)); }

  /// The same at a distance from the border, positive inside, before the first of the background's colours.
  [[nodiscard]] Rgb light_at(double depth) const { return mixed(blurred(depth), edge_.background); }

  [[nodiscard]] ImageView view() const {
    const int bytes = edge_.gray ? 1 : 3;
    return {pixels_.data(), edge_.size, edge_.size, std::ptrdiff_t{bytes} * edge_.size,
            edge_.gray ? PixelFormat::kGray8 : PixelFormat::kBgr8};
  }

 private:
  static constexpr int kFine = 64;  // profile steps per pixel
  static constexpr int kReach = 8;  // pixels from the border beyond which blur changes nothing

  // How much of the part's and of the background's light comes from a place.
  struct Share {
    double part = 0;
    double outside = 0;
  };

  [[nodiscard]] Rgb mixed(const Share& share, const Rgb& background) const {
    Rgb light{};
    for (std::size_t c = 0; c < 3; ++c) light[c] = share.part * edge_.part[c] + share.outside * background[c];
    return light;
  }

  // The waves are long against the blur, so it leaves them as they are.
  [[nodiscard]] Rgb background(int x, int y) const {
    if (edge_.texture_px == 0) return edge_.background;
    const double turn = 2 * std::numbers::pi / edge_.texture_px;
    const double wave = 0.5 + (std::sin(turn * (x + 0.3 * y)) + std::sin(turn * (0.8 * y - 0.5 * x) + edge_.seed)) / 4;
    Rgb color{};
    for (std::size_t c = 0; c < 3; ++c) color[c] = (1 - wave) * edge_.background[c] + wave * edge_.second[c];
    return color;
  }

  [[nodiscard]] Share blurred(double depth) const {
    const double place = (depth + kReach) * kFine - 0.5;
    if (place < 0 || place >= static_cast<double>(profile_.size() - 1)) return share_at(depth);
    const auto low = static_cast<std::size_t>(place);
    const double share = place - static_cast<double>(low);
    const Share& a = profile_[low];
    const Share& b = profile_[low + 1];
    return {std::lerp(a.part, b.part, share), std::lerp(a.outside, b.outside, share)};
  }

  [[nodiscard]] Share share_at(double depth) const {
    if (depth < 0) return {0, 1};
    const double section =
        edge_.limb_px > 0 ? std::min(depth, edge_.limb_px) / edge_.limb_px - 1 : 0;  // -1 at the limb, 0 in the middle
    const double facing = edge_.limb_px > 0 ? std::sqrt(std::max(0.0, 1 - section * section)) : 1;
    const double lit = std::cos(edge_.light_rad) * facing - std::sin(edge_.light_rad) * section;
    return {edge_.ambient + (1 - edge_.ambient) * std::max(0.0, lit), 0};
  }

  // Gauss and box, then the square pixel seen along the normal: two boxes as wide as the normal's components.
  [[nodiscard]] std::vector<double> aperture() const {
    constexpr int kHalf = 5 * kFine;
    std::vector<double> kernel(2 * kHalf + 1);
    for (int i = -kHalf; i <= kHalf; ++i) {
      const double d = static_cast<double>(i) / kFine / std::max(edge_.blur_px, 1e-3);
      kernel[static_cast<std::size_t>(i + kHalf)] = std::exp(-d * d / 2);
    }
    for (const double side : {edge_.box_px, std::cos(edge_.angle_rad), std::sin(edge_.angle_rad)}) {
      kernel = boxed(kernel, side);
    }
    double sum = 0;
    for (const double weight : kernel) sum += weight;
    for (double& weight : kernel) weight /= sum;
    return kernel;
  }

  static std::vector<double> boxed(const std::vector<double>& kernel, double side) {
    const int half = std::abs(static_cast<int>(std::lround(side * kFine / 2)));
    const int size = static_cast<int>(kernel.size());
    std::vector<double> result(kernel.size());
    for (int i = 0; i < size; ++i) {
      for (int k = -half; k <= half; ++k) {
        // The outermost steps count half: the box is 2 * half steps wide.
        const double weight = half > 0 && std::abs(k) == half ? 0.5 : 1;
        if (i + k >= 0 && i + k < size) {
          result[static_cast<std::size_t>(i)] += weight * kernel[static_cast<std::size_t>(i + k)];
        }
      }
    }
    return result;
  }

  void put(double light, double noise) {
    const double code = (edge_.linear_codes ? 255 * light : code_of_light(light)) + noise;
    pixels_.push_back(static_cast<std::uint8_t>(std::clamp(std::lround(code), 0L, 255L)));
  }

  SlantedEdge edge_;
  std::vector<Share> profile_;
  std::vector<std::uint8_t> pixels_;
};

/// Where a located edge pixel says the border is, as (x, y).
inline std::array<double, 2> located(const EdgePixel& pixel) {
  const double length = std::hypot(pixel.gx, pixel.gy);
  const double offset = pixel.offset_256 / 256.0;
  return {pixel.x + offset * pixel.gx / length, pixel.y + offset * pixel.gy / length};
}

}  // namespace cylpose::testing
