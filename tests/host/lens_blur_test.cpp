#include "lens_blur.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cylpose/render.hpp>
#include <numbers>
#include <opencv2/core.hpp>

#include "scene_pictures.hpp"

namespace cylpose {
namespace {

constexpr int kWidth = 40;
constexpr int kHeight = 30;

// A white box before black whose left side is seen at the column `edge`, the other sides outside of the picture.
Scene step_scene(double edge) {
  Scene scene;
  scene.camera = small_camera();
  scene.camera.width = kWidth;
  scene.camera.height = kHeight;
  scene.camera.cx = 18.7;
  scene.camera.cy = 14.2;
  scene.lighting = flat_light();
  scene.background.color = LinearRgb::Zero();
  constexpr double kHalfM = 10;
  constexpr double kHalfThicknessM = 1e-6;                         // its left side is seen, too
  const double left = (edge - scene.camera.cx) / scene.camera.fx;  // at a depth of 1 m, where the box begins
  scene.others = {
      {BoxSolid{
           {left + kHalfM, 0, 1 + kHalfThicknessM}, Eigen::Matrix3d::Identity(), {kHalfM, kHalfM, kHalfThicknessM}},
       plain(LinearRgb::Ones())}};
  return scene;
}

// Integral of the normal distribution function from -infinity to `place`, in sigmas.
double integral_of_normal(double place) {
  const double density = std::exp(-place * place / 2) / std::sqrt(2 * std::numbers::pi);
  return place * 0.5 * std::erfc(-place / std::numbers::sqrt2) + density;
}

// The light that a pixel gathers of a step at `edge`, blurred by a lens: the mean of the normal distribution function.
double gathered(int column, double edge, double sigma_px) {
  return sigma_px *
         (integral_of_normal((column + 0.5 - edge) / sigma_px) - integral_of_normal((column - 0.5 - edge) / sigma_px));
}

TEST(LensBlur, OfAStepIsTheMeanOverThePixelWhereverTheStepCrossesIt) {
  for (const double sigma_px : {0.3, 0.6, 1.5}) {
    for (const double edge : {20.5, 20.37, 20.11, 19.93, 19.74}) {
      const cv::Mat light = blurred(render(step_scene(edge)), BlurKernel::kGaussian, sigma_px);
      for (int column = 14; column < 27; ++column) {
        const double mean = cv::mean(light.col(column))[0];
        // Where the step crosses a cell its light is spread over the cell.
        EXPECT_NEAR(mean, gathered(column, edge, sigma_px), sigma_px < 0.5 ? 0.012 : 0.006)
            << "sigma " << sigma_px << " step at " << edge << " column " << column;
      }
    }
  }
}

TEST(LensBlur, OfABoxIsTheShareOfTheSquareThatIsLit) {
  constexpr double kSigmaPx = 0.6;
  constexpr double kEdge = 20.2;
  const cv::Mat light = blurred(render(step_scene(kEdge)), BlurKernel::kBox, kSigmaPx);
  const double half = std::numbers::sqrt3 * kSigmaPx;
  for (int column = 16; column < 25; ++column) {
    double share = 0;  // over the pixel
    constexpr int kSteps = 1000;
    for (int i = 0; i < kSteps; ++i) {
      const double place = column - 0.5 + (i + 0.5) / kSteps;
      share += std::clamp((place - kEdge + half) / (2 * half), 0.0, 1.0) / kSteps;
    }
    EXPECT_NEAR(cv::mean(light.col(column))[0], share, 0.004) << column;
  }
}

TEST(LensBlur, LeavesEvenLightAloneWhereManyPixelsAreMixed) {
  // Two things of the same light: edges, but nothing to be seen of them.
  Scene scene = step_scene(20.3);
  scene.background.color = LinearRgb::Ones();
  const SceneLight light = render(scene);
  ASSERT_GT(light.mixed.size(), static_cast<std::size_t>(kHeight));
  EXPECT_LT(cv::norm(blurred(light, BlurKernel::kGaussian, 0.6), light.pixels, cv::NORM_INF), 1e-5);
}

TEST(LensBlur, LosesNoLightAtTheBorderOfThePicture) {
  for (const BlurKernel kernel : {BlurKernel::kGaussian, BlurKernel::kBox, BlurKernel::kMotion}) {
    for (const double edge : {0.2, 39.3}) {
      const SceneLight light = render(step_scene(edge));
      const double before = cv::sum(light.pixels)[1];
      EXPECT_NEAR(cv::sum(blurred(light, kernel, 2.5))[1], before, 1e-4 * kWidth * kHeight);
    }
  }
}

TEST(LensBlur, OfMotionStaysInItsRow) {
  cv::Mat point(9, 21, CV_32FC3, cv::Scalar::all(0));
  point.at<cv::Vec3f>(4, 10) = cv::Vec3f::all(1);
  SceneLight light(point);
  light.mixed.push_back({10, 4, {}});
  light.mixed[0].excess[0][0] = cv::Vec3f::all(0.5F);  // all of it in the upper left
  light.mixed[0].excess[3][3] = cv::Vec3f::all(-0.5F);
  const cv::Mat moved = blurred(light, BlurKernel::kMotion, 1.5);
  EXPECT_NEAR(cv::sum(moved.row(4))[0], 1, 1e-5);
  EXPECT_NEAR(cv::norm(moved, cv::NORM_L1), cv::norm(moved.row(4), cv::NORM_L1), 1e-6);
  EXPECT_GT(moved.at<cv::Vec3f>(4, 7)[0], moved.at<cv::Vec3f>(4, 13)[0] + 0.01F) << "more came from the left";
}

}  // namespace
}  // namespace cylpose
