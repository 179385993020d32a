#include "camera_effects.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cylpose/srgb.hpp>
#include <opencv2/core.hpp>
#include <string>

namespace cylpose {
namespace {

std::uint8_t rounded_code(double code) {
  return static_cast<std::uint8_t>(std::clamp(code + 0.5, 0.0, 255.0));
}

// Luma and the two colour differences of B G R codes.
cv::Vec3f ycc_of(const cv::Vec3b& bgr) {
  const float y =
      0.114F * static_cast<float>(bgr[0]) + 0.587F * static_cast<float>(bgr[1]) + 0.299F * static_cast<float>(bgr[2]);
  return {y, (static_cast<float>(bgr[0]) - y) / 1.772F, (static_cast<float>(bgr[2]) - y) / 1.402F};
}

cv::Vec3b bgr_of(float y, float cb, float cr) {
  const float blue = y + 1.772F * cb;
  const float red = y + 1.402F * cr;
  const float green = (y - 0.114F * blue - 0.299F * red) / 0.587F;
  return {rounded_code(blue), rounded_code(green), rounded_code(red)};
}

}  // namespace

bool CameraEffects::is_valid(std::string* why) const {
  const auto refuse = [&](const std::string& reason) {
    if (why != nullptr) *why = reason;
    return false;
  };
  if (!(vignetting >= 0 && vignetting <= 1)) {
    return refuse("vignetting of " + std::to_string(vignetting) + " is not within 0 to 1");
  }
  if (!(sharpening >= 0 && sharpening <= 4)) {
    return refuse("sharpening of " + std::to_string(sharpening) + " is not within 0 to 4");
  }
  return true;
}

cv::Mat vignetted(const cv::Mat& light, double loss) {
  cv::Mat dimmed = light.clone();
  const double middle_x = (light.cols - 1) / 2.0;
  const double middle_y = (light.rows - 1) / 2.0;
  const double corner_squared = std::max(1.0, middle_x * middle_x + middle_y * middle_y);
  for (int y = 0; y < light.rows; ++y) {
    for (int x = 0; x < light.cols; ++x) {
      const double squared = (x - middle_x) * (x - middle_x) + (y - middle_y) * (y - middle_y);
      dimmed.at<cv::Vec3f>(y, x) *= static_cast<float>(1 - loss * squared / corner_squared);
    }
  }
  return dimmed;
}

cv::Mat with_noise_in_light(const cv::Mat& light, NoiseKind kind, double sigma, PortableRandom* random) {
  const double grey = linear_from_srgb(128 / 255.0);
  const double light_per_code = linear_from_srgb(128.5 / 255) - linear_from_srgb(127.5 / 255);
  const double share = sigma * light_per_code / (kind == NoiseKind::kShot ? std::sqrt(grey) : grey);
  cv::Mat noisy = light.clone();
  for (int y = 0; y < light.rows; ++y) {
    float* row = noisy.ptr<float>(y);
    for (int i = 0; i < 3 * light.cols; ++i) {
      const double value = std::max(0.0F, row[i]);
      const double grown = kind == NoiseKind::kShot ? std::sqrt(value) : value;
      row[i] = static_cast<float>(value + share * grown * random->gaussian());
    }
  }
  return noisy;
}

cv::Mat sharpened(const cv::Mat& coded, double amount) {
  cv::Mat result(coded.size(), coded.type());
  for (int y = 0; y < coded.rows; ++y) {
    for (int x = 0; x < coded.cols; ++x) {
      cv::Vec3i around(0, 0, 0);
      for (int dy = -1; dy <= 1; ++dy) {
        for (int dx = -1; dx <= 1; ++dx) {
          const auto& neighbour = coded.at<cv::Vec3b>(std::clamp(y + dy, 0, coded.rows - 1),  //
                                                      std::clamp(x + dx, 0, coded.cols - 1));
          around += (2 - std::abs(dx)) * (2 - std::abs(dy)) * cv::Vec3i(neighbour[0], neighbour[1], neighbour[2]);
        }
      }
      for (int c = 0; c < 3; ++c) {
        const double own = coded.at<cv::Vec3b>(y, x)[c];
        result.at<cv::Vec3b>(y, x)[c] = rounded_code(own + amount * (own - around[c] / 16.0));
      }
    }
  }
  return result;
}

cv::Mat with_chroma_420(const cv::Mat& coded) {
  // Sums over what lies in the picture of every block.
  cv::Mat_<cv::Vec2f> chroma((coded.rows + 1) / 2, (coded.cols + 1) / 2, cv::Vec2f(0, 0));
  cv::Mat_<float> pixels(chroma.size(), 0.0F);
  for (int y = 0; y < coded.rows; ++y) {
    for (int x = 0; x < coded.cols; ++x) {
      const cv::Vec3f ycc = ycc_of(coded.at<cv::Vec3b>(y, x));
      chroma(y / 2, x / 2) += cv::Vec2f(ycc[1], ycc[2]);
      pixels(y / 2, x / 2) += 1;
    }
  }
  const auto mean = [&](int y, int x) -> cv::Vec2f {
    const int by = std::clamp(y, 0, chroma.rows - 1);
    const int bx = std::clamp(x, 0, chroma.cols - 1);
    return chroma(by, bx) * (1 / pixels(by, bx));
  };
  cv::Mat result(coded.size(), coded.type());
  for (int y = 0; y < coded.rows; ++y) {
    for (int x = 0; x < coded.cols; ++x) {
      // A pixel lies a quarter of a block beside the middle of its own block.
      const int beside_y = y / 2 + (y % 2 == 0 ? -1 : 1);
      const int beside_x = x / 2 + (x % 2 == 0 ? -1 : 1);
      const cv::Vec2f cc = 0.5625F * mean(y / 2, x / 2) + 0.1875F * (mean(beside_y, x / 2) + mean(y / 2, beside_x)) +
                           0.0625F * mean(beside_y, beside_x);
      result.at<cv::Vec3b>(y, x) = bgr_of(ycc_of(coded.at<cv::Vec3b>(y, x))[0], cc[0], cc[1]);
    }
  }
  return result;
}

}  // namespace cylpose
