#include <algorithm>
#include <cmath>
#include <cylpose/error.hpp>
#include <cylpose/render.hpp>
#include <cylpose/srgb.hpp>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "camera_effects.hpp"
#include "portable_random.hpp"

// Plain loops instead of OpenCV's filters: those differ in the last bit from one processor to the next, and with them
// the rounded bytes.

namespace cylpose {
namespace {

constexpr double kMaxBlurSigma = 50;  // pixels

// Samples of the kernel, normalised; the entry [i] belongs to the distance i. The Gaussian goes out to 4 sigma; a box
// ends between pixels, and counts the last ones by the share that it covers.
std::vector<float> half_kernel(double sigma, bool box) {
  const double half_width = box ? std::sqrt(3.0) * sigma : 4 * sigma;
  const int radius = static_cast<int>(std::ceil(half_width));
  std::vector<double> weights;
  double sum = 0;
  for (int i = 0; i <= radius; ++i) {
    weights.push_back(box ? std::clamp(half_width + 0.5 - i, 0.0, 1.0) : std::exp(-i * i / (2 * sigma * sigma)));
    sum += (i == 0 ? 1 : 2) * weights.back();
  }
  std::vector<float> kernel(weights.size());
  std::transform(weights.begin(), weights.end(), kernel.begin(),
                 [&](double weight) { return static_cast<float>(weight / sum); });
  return kernel;
}

// Mirrored at the border's outer edge (c b a | a b c), which loses no light.
int mirrored(int i, int size) {
  const int period = 2 * size;
  const int wrapped = ((i % period) + period) % period;
  return wrapped < size ? wrapped : period - 1 - wrapped;
}

cv::Mat blurred_rows(const cv::Mat& light, const std::vector<float>& kernel) {
  const int radius = static_cast<int>(kernel.size()) - 1;
  const auto channels = static_cast<std::size_t>(light.channels());
  cv::Mat out(light.size(), light.type());
  std::vector<float> padded((static_cast<std::size_t>(light.cols) + 2 * static_cast<std::size_t>(radius)) * channels);
  for (int y = 0; y < light.rows; ++y) {
    const float* in_row = light.ptr<float>(y);
    for (int x = -radius; x < light.cols + radius; ++x) {
      std::copy_n(in_row + static_cast<std::size_t>(mirrored(x, light.cols)) * channels, channels,
                  padded.begin() + (x + radius) * static_cast<std::ptrdiff_t>(channels));
    }
    float* out_row = out.ptr<float>(y);
    const std::size_t count = static_cast<std::size_t>(light.cols) * channels;
    const float* middle = padded.data() + static_cast<std::size_t>(radius) * channels;
    for (std::size_t i = 0; i < count; ++i) out_row[i] = kernel[0] * middle[i];
    for (std::size_t k = 1; k < kernel.size(); ++k) {
      const float* left = middle - k * channels;
      const float* right = middle + k * channels;
      for (std::size_t i = 0; i < count; ++i) out_row[i] += kernel[k] * (left[i] + right[i]);
    }
  }
  return out;
}

cv::Mat blurred_columns(const cv::Mat& light, const std::vector<float>& kernel) {
  cv::Mat out(light.size(), light.type());
  const std::size_t count = static_cast<std::size_t>(light.cols) * static_cast<std::size_t>(light.channels());
  for (int y = 0; y < light.rows; ++y) {
    float* out_row = out.ptr<float>(y);
    const float* middle = light.ptr<float>(y);
    for (std::size_t i = 0; i < count; ++i) out_row[i] = kernel[0] * middle[i];
    for (int k = 1; k < static_cast<int>(kernel.size()); ++k) {
      const float weight = kernel[static_cast<std::size_t>(k)];
      const float* above = light.ptr<float>(mirrored(y - k, light.rows));
      const float* below = light.ptr<float>(mirrored(y + k, light.rows));
      for (std::size_t i = 0; i < count; ++i) out_row[i] += weight * (above[i] + below[i]);
    }
  }
  return out;
}

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

cv::Mat degrade(const cv::Mat& light, const DegradeOptions& options) {
  std::string why;
  if (!options.is_valid(&why)) throw Error(ErrorKind::kInput, why);
  if (light.empty() || light.type() != CV_32FC3) {
    throw Error(ErrorKind::kInput, "light must be a picture of three float channels, as render() makes it");
  }
  const CameraEffects& effects = options.effects;
  cv::Mat blurred = light;
  if (options.blur_sigma_px > 0) {
    const std::vector<float> kernel = half_kernel(options.blur_sigma_px, effects.blur != BlurKernel::kGaussian);
    blurred = blurred_rows(light, kernel);
    if (effects.blur != BlurKernel::kMotion) blurred = blurred_columns(blurred, kernel);
  }
  if (effects.vignetting > 0) blurred = vignetted(blurred, effects.vignetting);
  const Coder coder(options.transfer, effects.gamma_2_2);
  PortableRandom random(options.seed);
  const bool noise_in_codes = effects.noise == NoiseKind::kGaussian;
  if (options.noise_sigma > 0 && !noise_in_codes) {
    blurred = with_noise_in_light(blurred, effects.noise, options.noise_sigma, &random);
  }
  cv::Mat coded(light.size(), CV_8UC3);
  for (int y = 0; y < coded.rows; ++y) {
    const float* in = blurred.ptr<float>(y);
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
