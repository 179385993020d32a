// Pictures of synthetic scenes with exact truth: first the light that comes to the camera, then, as a step of its own,
// what lens and sensor make of it.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <cylpose/scene.hpp>
#include <opencv2/core/mat.hpp>
#include <string>
#include <vector>

namespace cylpose {

/// A pixel in which more than one surface is seen, divided into kCells x kCells cells.
struct MixedPixel {
  static constexpr std::size_t kCells = 4;
  int x = 0;
  int y = 0;
  /// By row and column, each cell's part of the pixel's light less its share in an evenly lit pixel (B G R); the sum is
  /// zero.
  std::array<std::array<cv::Vec3f, kCells>, kCells> excess = {};
};

/// Light as it comes to a camera, before the lens has blurred it.
struct SceneLight {
  SceneLight(cv::Mat light, std::vector<MixedPixel> unevenly_lit = {});  // NOLINT(google-explicit-constructor)

  cv::Mat pixels;                 ///< mean over each pixel: CV_32FC3, B G R, linear, not limited to 1
  std::vector<MixedPixel> mixed;  ///< the others are lit evenly
};

/// A pixel is the square [x - 0.5, x + 0.5) x [y - 0.5, y + 0.5), its centre (x, y); the lens distortion of the camera
/// is honoured. Pixels at the border of a part are integrated with a shifted lattice of 233 rays, so that the border's
/// place has no bias and errs by about 0.003 px in one pixel; at other edges 34 rays do; elsewhere the ray through the
/// centre. Throws Error(kInput) for a camera or part that cannot be.
[[nodiscard]] SceneLight render(const Scene& scene);

/// Share of every pixel, 0..1, in which the part (an index into `scene.parts`) is what the camera sees: CV_32FC1.
[[nodiscard]] cv::Mat render_coverage(const Scene& scene, std::size_t part);

/// The pixels of which the part covers at least half: CV_8UC1, 0 or 255.
[[nodiscard]] cv::Mat truth_mask(const Scene& scene, std::size_t part);

/// How a point of light is spread. All have the standard deviation that is asked for, in the directions they blur.
enum class BlurKernel : std::uint8_t {
  kGaussian,
  kBox,     ///< a square, evenly filled
  kMotion,  ///< along the rows only, evenly: the camera turns while it exposes
};

/// How noise depends on the light. All have the standard deviation that is asked for at a grey of code 128.
enum class NoiseKind : std::uint8_t {
  kGaussian,  ///< the same in all codes
  kShot,      ///< in the light, growing with its root: photons (many enough to be normally distributed)
  kSpeckle,   ///< in the light, growing with it
};

/// What some cameras do and the method does not model: to try it beyond its assumptions.
struct CameraEffects {
  BlurKernel blur = BlurKernel::kGaussian;
  NoiseKind noise = NoiseKind::kGaussian;
  bool gamma_2_2 = false;  ///< codes by the power 1/2.2, whatever the transfer
  double vignetting = 0;   ///< share of the light that is lost in the corners, 0..1; it falls with the squared distance
  double sharpening = 0;  ///< share of a pixel's difference from its surroundings (3x3) that is added to its code, 0..4
  bool chroma_420 = false;  ///< colour differences (BT.601) kept for blocks of 2x2 pixels only, as video does

  [[nodiscard]] bool is_valid(std::string* why) const;
};

/// What lens and sensor add.
struct DegradeOptions {
  double blur_sigma_px = 0.6;  ///< blur of the light, pixels; 0: none. At most 50.
  double noise_sigma = 1.5;    ///< noise, code values 0..255, per channel; 0: none
  Transfer transfer = Transfer::kSrgb;
  std::uint64_t seed = 1;  ///< of the noise
  CameraEffects effects = {};

  [[nodiscard]] bool is_valid(std::string* why) const;
};

/// The picture that a camera delivers: blurred in linear light before the pixels gather it, coded, noisy, rounded and
/// cut to 0..255; then sharpened and its chroma subsampled, where asked for. CV_8UC3, B G R. The same light and options
/// give the same bytes with every compiler and standard library. Throws Error(kInput) for options out of range or a
/// picture that render() does not make.
[[nodiscard]] cv::Mat degrade(const SceneLight& light, const DegradeOptions& options);

}  // namespace cylpose
