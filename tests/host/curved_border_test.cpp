#include <gtest/gtest.h>

#include <cmath>
#include <cylpose/backend.hpp>
#include <cylpose/curved_border.hpp>
#include <cylpose/image_cv.hpp>
#include <cylpose/srgb.hpp>
#include <opencv2/imgproc.hpp>

#include "slanted_edge.hpp"

namespace cylpose {
namespace {

constexpr int kSize = 128;

// A red disc before grey, through a lens that blurs by 0.6 px.
cv::Mat picture_of_disc(const cv::Point2d& center, double radius_px) {
  constexpr int kFiner = 16;
  cv::Mat share(kSize * kFiner, kSize * kFiner, CV_32F);
  for (int y = 0; y < share.rows; ++y) {
    for (int x = 0; x < share.cols; ++x) {
      const cv::Point2d place((x + 0.5) / kFiner - 0.5, (y + 0.5) / kFiner - 0.5);
      share.at<float>(y, x) = cv::norm(place - center) < radius_px ? 1 : 0;
    }
  }
  cv::GaussianBlur(share, share, {}, 0.6 * kFiner);
  cv::resize(share, share, {kSize, kSize}, 0, 0, cv::INTER_AREA);
  const testing::Rgb red = testing::light_of_codes(200, 40, 40);
  const testing::Rgb grey = testing::light_of_codes(140, 140, 140);
  cv::Mat picture(kSize, kSize, CV_8UC3);
  for (int y = 0; y < kSize; ++y) {
    for (int x = 0; x < kSize; ++x) {
      const double of_disc = share.at<float>(y, x);
      for (const std::size_t c : {0U, 1U, 2U}) {
        const double light = of_disc * red[c] + (1 - of_disc) * grey[c];
        picture.at<cv::Vec3b>(y, x)[static_cast<int>(2 - c)] = cv::saturate_cast<uchar>(255 * srgb_from_linear(light));
      }
    }
  }
  return picture;
}

TEST(CurvedBorder, EdgesLieAsFarInsideAsTheCurvatureSays) {
  const PartModel red{"red", 0.05, 0.4, 340, 20, 0.3, 0.1};
  for (const double radius_px : {6.0, 10.0, 16.0, 40.0}) {
    double sum_px = 0;
    int count = 0;
    for (const double phase : {0.0, 0.21, 0.47, 0.73}) {
      const cv::Point2d center(63.5 + phase, 63.2 - 0.6 * phase);
      const cv::Mat picture = picture_of_disc(center, radius_px);
      const ImageView image = view_of(picture);
      const EdgeField field = make_backend("serial")->detect(image, image.bounds(), {&red, 1}, {});
      for (const EdgePixel& edge : field.parts.at(0).edges) {
        const auto [x, y] = testing::located(edge);
        sum_px += radius_px - cv::norm(cv::Point2d(x, y) - center);
        ++count;
      }
    }
    ASSERT_GT(count, 100);
    EXPECT_NEAR(sum_px / count, inward_shift_px(1 / radius_px), 0.25 * inward_shift_px(1 / radius_px) + 0.002)
        << radius_px;
  }
}

}  // namespace
}  // namespace cylpose
