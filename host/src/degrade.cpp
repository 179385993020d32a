#include <algorithm>
#include <cmath>
#include <cylpose/error.hpp>
#include <cylpose/render.hpp>
#include <cylpose/srgb.hpp>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "camera_effects.hpp"
#include "lens_blur.hpp"
#include "portable_random.hpp"

namespace cylpose {
namespace {

constexpr double kMaxBlurSigma = 50;  // pixels

// Code values 0..255 of light 0..1, from a table: a frame has millions of values, and pow is slow.
class Coder {
 public:
  Coder(Transfer transfer, bool gamma_2_2) : codes_(kSteps + 2) {
    for (std::size_t i = 0; i < codes_.size(); ++i) {
      const double light = static_cast<double>(i) / kSteps;
      const double of_transfer = transfer == Transfer::kSrgb ? srgb_from_linear(light) : light;
      codes_[i] = static_cast<float>(255 * (gamma_2_2 ? std::pow(light, 1 / 2.2) : of_transfer));
    }
  }

  // The light is cut to 0..1, as a sensor saturates (NaN to 0). Linear between the steps: off by less than 1e-4 of a
  // code value.
  [[nodiscard]] float code_of(float light) const {
    const float place = (light > 0 ? std::min(light, 1.0F) : 0.0F) * kSteps;
    const auto step = static_cast<std::size_t>(place);
    return codes_[step] + (place - static_cast<float>(step)) * (codes_[step + 1] - codes_[step]);
  }

 private:
  static constexpr int kSteps = 16384;
  std::vector<float> codes_;
};

}  // namespace

bool DegradeOptions::is_valid(std::string* why) const {
  const auto refuse = [&](const std::string& reason) {
    if (why != nullptr) *why = reason;
    return false;
  };
  if (!(blur_sigma_px >= 0 && blur_sigma_px <= kMaxBlurSigma)) {
    return refuse("blur of " + std::to_string(blur_sigma_px) + " px is not within 0 to 50");
  }
  if (!(noise_sigma >= 0 && noise_sigma <= 255)) {
    return refuse("noise of " + std::to_string(noise_sigma) + " code values is not within 0 to 255");
  }
  return effects.is_valid(why);
}

cv::Mat degrade(const SceneLight& light, const DegradeOptions& options) {
  std::string why;
  if (!options.is_valid(&why)) throw Error(ErrorKind::kInput, why);
  if (light.pixels.empty() || light.pixels.type() != CV_32FC3) {
    throw Error(ErrorKind::kInput, "light must be a picture of three float channels, as render() makes it");
  }
  const CameraEffects& effects = options.effects;
  cv::Mat on_sensor = options.blur_sigma_px > 0 ? blurred(light, effects.blur, options.blur_sigma_px) : light.pixels;
  if (effects.vignetting > 0) on_sensor = vignetted(on_sensor, effects.vignetting);
  const Coder coder(options.transfer, effects.gamma_2_2);
  PortableRandom random(options.seed);
  const bool noise_in_codes = effects.noise == NoiseKind::kGaussian;
  if (options.noise_sigma > 0 && !noise_in_codes) {
    on_sensor = with_noise_in_light(on_sensor, effects.noise, options.noise_sigma, &random);
  }
  cv::Mat coded(on_sensor.size(), CV_8UC3);
  for (int y = 0; y < coded.rows; ++y) {
    const float* in = on_sensor.ptr<float>(y);
    std::uint8_t* out = coded.ptr<std::uint8_t>(y);
    for (int i = 0; i < 3 * coded.cols; ++i) {
      double code = static_cast<double>(coder.code_of(in[i]));
      if (options.noise_sigma > 0 && noise_in_codes) code += options.noise_sigma * random.gaussian();
      out[i] = static_cast<std::uint8_t>(std::clamp(code + 0.5, 0.0, 255.0));
    }
  }
  if (effects.sharpening > 0) coded = sharpened(coded, effects.sharpening);
  if (effects.chroma_420) coded = with_chroma_420(coded);
  return coded;
}

}  // namespace cylpose
