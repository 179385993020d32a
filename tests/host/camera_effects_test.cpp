#include <gtest/gtest.h>

#include <cmath>
#include <cylpose/error.hpp>
#include <cylpose/render.hpp>
#include <opencv2/core.hpp>

namespace cylpose {
namespace {

cv::Mat even_light(int width, int height, double light) {
  return {height, width, CV_32FC3, cv::Scalar::all(light)};
}

cv::Mat point_of_light(int size) {
  cv::Mat light = even_light(size, size, 0);
  light.at<cv::Vec3f>(size / 2, size / 2) = cv::Vec3f::all(1);
  return light;
}

DegradeOptions pure(const CameraEffects& effects) {
  return {0, 0, Transfer::kLinear, 1, effects};
}

// Standard deviations of a blurred point along the rows and along the columns.
cv::Vec2d spread(const cv::Mat& picture) {
  double sum = 0;
  cv::Vec2d squares(0, 0);
  const int middle = picture.rows / 2;
  for (int y = 0; y < picture.rows; ++y) {
    for (int x = 0; x < picture.cols; ++x) {
      const double code = picture.at<cv::Vec3b>(y, x)[1];
      sum += code;
      squares += code * cv::Vec2d((x - middle) * (x - middle), (y - middle) * (y - middle));
    }
  }
  return {std::sqrt(squares[0] / sum), std::sqrt(squares[1] / sum)};
}

TEST(CameraEffects, KernelsHaveTheirSpreadAndShape) {
  const auto blurred = [](BlurKernel kernel) {
    DegradeOptions options = pure({});
    options.blur_sigma_px = 2;
    options.effects.blur = kernel;
    return degrade(point_of_light(41), options);
  };
  const cv::Mat box = blurred(BlurKernel::kBox);
  EXPECT_NEAR(spread(box)[0], 2, 0.1);
  EXPECT_NEAR(spread(box)[1], 2, 0.1);
  EXPECT_EQ(box.at<cv::Vec3b>(20, 20)[0], box.at<cv::Vec3b>(22, 23)[0]) << "a box is flat";
  const cv::Mat motion = blurred(BlurKernel::kMotion);
  EXPECT_NEAR(spread(motion)[0], 2, 0.1);
  EXPECT_EQ(spread(motion)[1], 0);
  EXPECT_GT(blurred(BlurKernel::kGaussian).at<cv::Vec3b>(20, 20)[0],
            blurred(BlurKernel::kGaussian).at<cv::Vec3b>(22, 23)[0]);
}

// Standard deviation of the codes, sRGB, of even light with noise of sigma 2.
double sigma_at_code(NoiseKind kind, double code) {
  DegradeOptions options;
  options.blur_sigma_px = 0;
  options.noise_sigma = 2;
  options.effects.noise = kind;
  const double light = std::pow((code / 255 + 0.055) / 1.055, 2.4);
  cv::Scalar mean;
  cv::Scalar deviation;
  cv::meanStdDev(degrade(even_light(200, 200, light), options), mean, deviation);
  EXPECT_NEAR(mean[1], code, 0.1);
  return std::sqrt(deviation[1] * deviation[1] - 1.0 / 12);
}

TEST(CameraEffects, NoiseGrowsWithTheLightAsItsKindDoes) {
  EXPECT_NEAR(sigma_at_code(NoiseKind::kShot, 128), 2, 0.05);
  EXPECT_NEAR(sigma_at_code(NoiseKind::kSpeckle, 128), 2, 0.05);
  // Codes rise with about the power 1/2.4 of light: noise in codes goes with light^(1/2.4 - 1/2) and light^(1/2.4).
  const double lights = std::pow((200 / 255.0 + 0.055) / (128 / 255.0 + 0.055), 2.4);
  EXPECT_NEAR(sigma_at_code(NoiseKind::kShot, 200), 2 * std::pow(lights, 1 / 2.4 - 0.5), 0.06);
  EXPECT_NEAR(sigma_at_code(NoiseKind::kSpeckle, 200), 2 * std::pow(lights, 1 / 2.4), 0.08);
}

TEST(CameraEffects, Gamma22IsThePower) {
  CameraEffects effects;
  effects.gamma_2_2 = true;
  EXPECT_NEAR(degrade(even_light(4, 4, 0.01), pure(effects)).at<cv::Vec3b>(1, 1)[0], 255 * std::pow(0.01, 1 / 2.2),
              0.51);
  EXPECT_NEAR(degrade(even_light(4, 4, 0.5), pure(effects)).at<cv::Vec3b>(1, 1)[0], 255 * std::pow(0.5, 1 / 2.2), 0.51);
}

TEST(CameraEffects, VignettingDimsTheCorners) {
  CameraEffects effects;
  effects.vignetting = 0.4;
  const cv::Mat picture = degrade(even_light(101, 51, 0.5), pure(effects));
  EXPECT_EQ(picture.at<cv::Vec3b>(25, 50)[2], 128);
  EXPECT_NEAR(picture.at<cv::Vec3b>(0, 0)[2], 127.5 * 0.6, 0.51);
  EXPECT_NEAR(picture.at<cv::Vec3b>(50, 100)[2], 127.5 * 0.6, 0.51);
  EXPECT_NEAR(picture.at<cv::Vec3b>(25, 100)[2], 127.5 * (1 - 0.4 * 0.8), 0.51);
}

TEST(CameraEffects, SharpeningLeavesEvenLightAndOvershootsAtSteps) {
  CameraEffects effects;
  effects.sharpening = 1;
  cv::Mat light = even_light(20, 10, 0.2);
  light.colRange(10, 20).setTo(cv::Scalar::all(0.6));
  const cv::Mat picture = degrade(light, pure(effects));
  EXPECT_EQ(picture.at<cv::Vec3b>(5, 3)[0], 51);
  EXPECT_EQ(picture.at<cv::Vec3b>(5, 9)[0], 26);  // 25.5 down and 25.5 up: halves round up
  EXPECT_EQ(picture.at<cv::Vec3b>(5, 10)[0], 179);
  EXPECT_EQ(picture.at<cv::Vec3b>(5, 16)[0], 153);
}

TEST(CameraEffects, Chroma420KeepsLumaAndHalvesColour) {
  CameraEffects effects;
  effects.chroma_420 = true;
  cv::Mat light = even_light(20, 10, 0.4);
  light.colRange(10, 20).setTo(cv::Scalar(0.2, 0.3, 0.6));
  const cv::Mat plain = degrade(light, pure({}));
  const cv::Mat picture = degrade(light, pure(effects));
  const auto luma = [](const cv::Vec3b& c) { return 0.114 * c[0] + 0.587 * c[1] + 0.299 * c[2]; };
  for (int x = 0; x < 20; ++x) {
    EXPECT_NEAR(luma(picture.at<cv::Vec3b>(5, x)), luma(plain.at<cv::Vec3b>(5, x)), 0.8) << x;
  }
  EXPECT_LE(cv::norm(picture.col(3), plain.col(3), cv::NORM_INF), 1);
  EXPECT_LE(cv::norm(picture.col(16), plain.col(16), cv::NORM_INF), 1);
  // A quarter of the step in B - Y beyond it: -0.25 * (51 - 78.6), less the luma's part.
  EXPECT_LT(picture.at<cv::Vec3b>(5, 9)[0], plain.at<cv::Vec3b>(5, 9)[0] - 4);
  EXPECT_GT(picture.at<cv::Vec3b>(5, 10)[0], plain.at<cv::Vec3b>(5, 10)[0] + 4);
}

TEST(CameraEffects, RefusesWhatCannotBe) {
  CameraEffects effects;
  effects.vignetting = 1.5;
  EXPECT_THROW((void)degrade(even_light(4, 4, 0.5), pure(effects)), Error);
  effects = {};
  effects.sharpening = std::nan("");
  EXPECT_THROW((void)degrade(even_light(4, 4, 0.5), pure(effects)), Error);
}

}  // namespace
}  // namespace cylpose
