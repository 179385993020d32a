#include <fmt/format.h>
#include <yaml-cpp/emitter.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstddef>
#include <cylpose/error.hpp>
#include <cylpose/image_cv.hpp>
#include <cylpose/tune.hpp>
#include <numbers>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "channels.hpp"

namespace cylpose {
namespace {

constexpr double kRadian = std::numbers::pi / 180;

// What the suggestion looks at, of the pixels that have a hue at all.
struct Sample {
  std::vector<double> hues_deg;
  std::vector<double> saturations;
  std::vector<double> values;
  std::complex<double> hue_sum;  // of unit vectors in the hues' directions
};

// Below this a pixel counts as grey: noise, or a tinge in the light, gives it a hue.
constexpr int kLeastChroma = 12;  // codes
constexpr double kLeastSaturation = 0.2;

double hue_of(int r, int g, int b, int high, int chroma) {
  double sextants = 0;
  if (high == r) {
    sextants = static_cast<double>(g - b) / chroma;
  } else if (high == g) {
    sextants = static_cast<double>(b - r) / chroma + 2;
  } else {
    sextants = static_cast<double>(r - g) / chroma + 4;
  }
  return 60 * sextants;
}

Sample colored_pixels(const ImageView& image, const Roi& roi) {
  Sample sample;
  const Channels channel = channels_of(image.format);
  for (int y = roi.y; y < roi.bottom(); ++y) {
    for (int x = roi.x; x < roi.right(); ++x) {
      const std::uint8_t* pixel = image.row(y) + static_cast<std::ptrdiff_t>(x) * channel.step;
      const int r = pixel[channel.red];
      const int g = pixel[channel.green];
      const int b = pixel[channel.blue];
      const int high = std::max({r, g, b});
      const int chroma = high - std::min({r, g, b});
      if (chroma < kLeastChroma || chroma < kLeastSaturation * high) continue;
      const double hue = hue_of(r, g, b, high, chroma);
      sample.hues_deg.push_back(hue);
      sample.saturations.push_back(static_cast<double>(chroma) / high);
      sample.values.push_back(high / 255.0);
      sample.hue_sum += std::polar(1.0, hue * kRadian);
    }
  }
  return sample;
}

// The value below which `share` of the values lie.
double quantile(std::vector<double>& values, double share) {
  const auto rank = values.begin() + std::lround(share * static_cast<double>(values.size() - 1));
  std::ranges::nth_element(values, rank);
  return *rank;
}

double floored_to_hundredths(double value) {
  return std::floor(100 * value) / 100;
}

// On the circle, 0 to below 360.
double wrapped(double degrees) {
  return degrees - 360 * std::floor(degrees / 360);
}

std::string text_of(const Roi& roi) {
  return fmt::format("{},{},{},{}", roi.x, roi.y, roi.width, roi.height);
}

void require_inside(const ImageView& image, const Roi& sample) {
  require_usable(image);
  if (image.format == PixelFormat::kGray8) {
    throw Error(ErrorKind::kInput, "the image is grey and has no hue to tune for; give a colour image");
  }
  if (sample.empty()) {
    throw Error(ErrorKind::kInput,
                fmt::format("sample rectangle {} is empty; width and height must be at least 1", text_of(sample)));
  }
  if (intersection(sample, image.bounds()) != sample) {
    throw Error(ErrorKind::kInput,
                fmt::format("sample rectangle {} (x,y,width,height) is not inside the image of {} x {} pixels; choose "
                            "one that lies on the part",
                            text_of(sample), image.width, image.height));
  }
}

}  // namespace

ColorSuggestion suggest_color(const ImageView& image, const Roi& sample) {
  require_inside(image, sample);
  Sample colored = colored_pixels(image, sample);
  const double all = static_cast<double>(sample.width) * sample.height;
  const double share = static_cast<double>(colored.hues_deg.size()) / all;
  if (share < 0.5) {
    throw Error(ErrorKind::kInput,
                fmt::format("{:.0f} % of the sample rectangle {} are grey, white or black and have no hue; choose one "
                            "that lies on the coloured part, or light the part better",
                            100 * (1 - share), text_of(sample)));
  }

  // Deviations from the mean direction do not wrap, so that ordinary quantiles can be taken of them.
  const double mean = std::arg(colored.hue_sum) / kRadian;
  for (double& hue : colored.hues_deg) hue = std::remainder(hue - mean, 360);
  constexpr double kTail = 0.02;
  const double lowest = quantile(colored.hues_deg, kTail);
  const double highest = quantile(colored.hues_deg, 1 - kTail);
  const double spread = highest - lowest;
  constexpr double kOneColor = 90;  // degrees; noise of a dark part stays well below, two primary colours are above
  if (spread > kOneColor) {
    throw Error(ErrorKind::kInput,
                fmt::format("the hues in the sample rectangle {} spread over {:.0f} degrees, more than one colour has; "
                            "choose one that lies on the part alone",
                            text_of(sample), spread));
  }

  constexpr double kLeastMargin = 6;
  const double margin = std::max(kLeastMargin, spread / 2);
  return {wrapped(std::floor(mean + lowest - margin)), wrapped(std::ceil(mean + highest + margin)),
          floored_to_hundredths(0.75 * quantile(colored.saturations, kTail)),
          floored_to_hundredths(0.5 * quantile(colored.values, kTail))};
}

std::string parts_file_text(const PartModel& part) {
  YAML::Emitter name;  // quotes it where YAML needs that
  name << part.name;
  const auto size = [](const char* key, double metres, const char* what) {
    return metres > 0 ? fmt::format("    {}: {}\n", key, metres)
                      : fmt::format("    {}: 0  # fill in: the cylinder's {} in metres\n", key, what);
  };
  return fmt::format(
      "parts:\n"
      "  - name: {}\n"
      "{}{}"
      "    hue_deg: [{}, {}]\n"
      "    min_saturation: {}\n"
      "    min_value: {}\n",
      name.c_str(), size("radius_m", part.radius_m, "radius"), size("height_m", part.height_m, "height"),
      part.hue_lo_deg, part.hue_hi_deg, part.min_saturation, part.min_value);
}

cv::Mat mask_picture(const ImageView& image, const Mask& mask, const Roi& sample) {
  cv::Mat bgr;
  switch (image.format) {
    case PixelFormat::kBgr8:
      bgr = mat_of(image);
      break;
    case PixelFormat::kRgb8:
      cv::cvtColor(mat_of(image), bgr, cv::COLOR_RGB2BGR);
      break;
    case PixelFormat::kGray8:
      cv::cvtColor(mat_of(image), bgr, cv::COLOR_GRAY2BGR);
      break;
  }
  cv::Mat left = bgr.clone();
  // The rectangle's line runs around the sample, so that the sample itself stays to be seen.
  cv::rectangle(left, cv::Rect(sample.x - 1, sample.y - 1, sample.width + 2, sample.height + 2),
                cv::Scalar(255, 255, 255));
  cv::Mat right = bgr * 0.25;
  const ImageView inside{mask.pixels.data(), mask.roi.width, mask.roi.height, mask.roi.width, PixelFormat::kGray8};
  bgr.copyTo(right, mat_of(inside));
  cv::Mat both;
  cv::hconcat(left, right, both);
  return both;
}

}  // namespace cylpose
