#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <cylpose/error.hpp>
#include <cylpose/render.hpp>
#include <opencv2/core.hpp>

#include "scene_pictures.hpp"

namespace cylpose {
namespace {

cv::Mat uniform_light(int width, int height, double light) {
  return {height, width, CV_32FC3, cv::Scalar::all(light)};
}

// Dark on the left, `light` from column `from` on.
cv::Mat step_light(int width, int height, int from, double light) {
  cv::Mat step = uniform_light(width, height, 0);
  step.colRange(from, width).setTo(cv::Scalar::all(light));
  return step;
}

constexpr DegradeOptions kPure = {0, 0, Transfer::kSrgb, 1};

std::uint8_t code_of(double light, Transfer transfer) {
  return degrade(uniform_light(4, 4, light), {0, 0, transfer, 1}).at<cv::Vec3b>(2, 1)[1];
}

TEST(Degrade, CodesAreThoseOfSrgb) {
  EXPECT_EQ(code_of(0, Transfer::kSrgb), 0);
  EXPECT_EQ(code_of(0.002, Transfer::kSrgb), 7);    // 12.92 * 0.002 * 255 = 6.59
  EXPECT_EQ(code_of(0.213, Transfer::kSrgb), 127);  // 127.2
  EXPECT_EQ(code_of(0.215, Transfer::kSrgb), 128);  // 127.8
  EXPECT_EQ(code_of(0.5, Transfer::kSrgb), 188);
  EXPECT_EQ(code_of(1, Transfer::kSrgb), 255);
  EXPECT_EQ(code_of(0.2, Transfer::kLinear), 51);
}

TEST(Degrade, LightBeyondTheRangeSaturates) {
  EXPECT_EQ(code_of(7, Transfer::kSrgb), 255);
  EXPECT_EQ(code_of(-1, Transfer::kSrgb), 0);
  EXPECT_EQ(code_of(std::nan(""), Transfer::kSrgb), 0);
}

TEST(Degrade, NoiseHasItsSigmaInCodeValues) {
  for (const double sigma : {1.5, 4.0}) {
    const cv::Mat image = degrade(uniform_light(400, 300, 0.2), {0, sigma, Transfer::kSrgb, 9});
    const double true_code = 255 * (1.055 * std::pow(0.2, 1 / 2.4) - 0.055);
    double sum[3] = {};
    double squares = 0;
    double fourth = 0;
    double neighbours = 0;
    double channels = 0;
    int beyond_3_sigma = 0;
    const double count = 3.0 * 400 * 300;
    for (int y = 0; y < image.rows; ++y) {
      for (int x = 0; x < image.cols; ++x) {
        for (int c = 0; c < 3; ++c) {
          const double error = image.at<cv::Vec3b>(y, x)[c] - true_code;
          sum[c] += error;
          squares += error * error;
          fourth += std::pow(error, 4);
          if (x > 0) neighbours += error * (image.at<cv::Vec3b>(y, x - 1)[c] - true_code);
          if (c > 0) channels += error * (image.at<cv::Vec3b>(y, x)[c - 1] - true_code);
          beyond_3_sigma += std::abs(error) > 3 * sigma ? 1 : 0;
        }
      }
    }
    for (const double one : sum) EXPECT_NEAR(one / (count / 3), 0, 0.03);
    const double variance = squares / count;
    EXPECT_NEAR(std::sqrt(variance - 1.0 / 12), sigma, 0.01 * sigma);  // rounding adds 1/12
    EXPECT_NEAR(fourth / count / (variance * variance), 3, 0.06);      // of a Gaussian
    EXPECT_NEAR(neighbours / squares, 0, 0.01);
    EXPECT_NEAR(channels / squares, 0, 0.01);
    EXPECT_GT(beyond_3_sigma, 0.001 * count);
  }
}

TEST(Degrade, BlurConservesLight) {
  // A square that touches the border: what would leave comes back.
  cv::Mat light = uniform_light(60, 50, 0);
  light(cv::Rect(0, 5, 30, 30)).setTo(cv::Scalar::all(0.8));
  const cv::Mat sharp = degrade(light, {0, 0, Transfer::kLinear, 1});
  const cv::Mat soft = degrade(light, {3, 0, Transfer::kLinear, 1});
  ASSERT_EQ(cv::sum(sharp)[1], 30 * 30 * 204);
  EXPECT_NEAR(cv::sum(soft)[1] / cv::sum(sharp)[1], 1, 1e-3);
  EXPECT_LT(soft.at<cv::Vec3b>(20, 28)[1], 180);
}

TEST(Degrade, BlurHasItsSigma) {
  for (const double sigma : {0.6, 2.0}) {
    const cv::Mat blurred = degrade(step_light(60, 20, 30, 1), {sigma, 0, Transfer::kLinear, 1});
    // The step's derivative is the kernel between two squares: evenly lit pixels and those that gather the light.
    double mean = 0;
    double square = 0;
    for (int x = 1; x < 60; ++x) {
      const double rise = (blurred.at<cv::Vec3b>(10, x)[1] - blurred.at<cv::Vec3b>(10, x - 1)[1]) / 255.0;
      mean += rise * x;
      square += rise * x * x;
    }
    EXPECT_NEAR(mean, 30, 0.01);
    EXPECT_NEAR(std::sqrt(square - mean * mean - 2.0 / 12), sigma, 0.02 * sigma);
  }
}

TEST(Degrade, BlursLightNotCodes) {
  const cv::Mat blurred = degrade(step_light(60, 20, 30, 1), {2, 0, Transfer::kSrgb, 1});
  const auto light_at = [&](int x) {
    const double code = blurred.at<cv::Vec3b>(10, x)[1] / 255.0;
    return std::pow((code + 0.055) / 1.055, 2.4);
  };
  // In linear light the two pixels beside a step are as far above as below the middle.
  EXPECT_NEAR(light_at(29) + light_at(30), 1, 0.01);
}

TEST(Degrade, SeedDecidesTheNoise) {
  const cv::Mat light = uniform_light(40, 30, 0.3);
  const auto noisy = [&](std::uint64_t seed) { return degrade(light, {0.6, 2, Transfer::kSrgb, seed}); };
  EXPECT_EQ(cv::norm(noisy(5), noisy(5), cv::NORM_INF), 0);
  EXPECT_GT(cv::norm(noisy(5), noisy(6), cv::NORM_INF), 2);
}

std::uint64_t fnv1a(const cv::Mat& image) {
  std::uint64_t hash = 0xcbf29ce484222325ULL;
  for (int y = 0; y < image.rows; ++y) {
    const auto* row = image.ptr<std::uint8_t>(y);
    for (std::size_t i = 0; i < static_cast<std::size_t>(image.cols) * image.elemSize(); ++i) {
      hash = (hash ^ row[i]) * 0x100000001b3ULL;
    }
  }
  return hash;
}

// Benchmarks compare over machines and years: the same seed has to give these very bytes.
TEST(Degrade, BytesAreTheSameEverywhere) {
  Scene scene = white_on_black({{0.05, 0.02, 0.9}, Eigen::Vector3d(0.6, -0.5, 0.4).normalized()});
  scene.lighting = {};
  scene.background = {TextureKind::kNoise, {0.1, 0.2, 0.3}, {0.6, 0.5, 0.4}, 0.1, 3};
  scene.parts[0].material.specular = 0.2;
  EXPECT_EQ(fnv1a(degrade(render(scene), {0.6, 1.5, Transfer::kSrgb, 42})), 14744471071925567294ULL);
}

TEST(Degrade, RefusesWhatCannotBe) {
  const cv::Mat light = uniform_light(4, 4, 0.5);
  EXPECT_THROW((void)degrade(light, {-1, 0, Transfer::kSrgb, 1}), Error);
  EXPECT_THROW((void)degrade(light, {51, 0, Transfer::kSrgb, 1}), Error);
  EXPECT_THROW((void)degrade(light, {0, std::nan(""), Transfer::kSrgb, 1}), Error);
  EXPECT_THROW((void)degrade(light, {0, 256, Transfer::kSrgb, 1}), Error);
  EXPECT_THROW((void)degrade(cv::Mat(4, 4, CV_8UC3), kPure), Error);
  EXPECT_THROW((void)degrade(cv::Mat(), kPure), Error);
}

TEST(Degrade, BlurWiderThanTheImage) {
  const cv::Mat blurred = degrade(uniform_light(3, 2, 0.2), {20, 0, Transfer::kLinear, 1});
  EXPECT_EQ(cv::norm(blurred, cv::Mat(2, 3, CV_8UC3, cv::Scalar::all(51)), cv::NORM_INF), 0);
}

}  // namespace
}  // namespace cylpose
