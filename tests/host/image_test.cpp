#include <gtest/gtest.h>

#include <array>
#include <cylpose/error.hpp>
#include <cylpose/image.hpp>
#include <cylpose/image_cv.hpp>

namespace cylpose {
namespace {

TEST(Roi, IntersectionHoldsWhatBothHold) {
  EXPECT_EQ(intersection({0, 0, 10, 8}, {4, 3, 10, 10}), (Roi{4, 3, 6, 5}));
  EXPECT_EQ(intersection({4, 3, 10, 10}, {0, 0, 10, 8}), (Roi{4, 3, 6, 5}));
  EXPECT_EQ(intersection({0, 0, 4, 4}, {4, 0, 4, 4}), Roi{});  // they touch
  EXPECT_EQ(intersection({-5, -5, 8, 8}, {0, 0, 100, 100}), (Roi{0, 0, 3, 3}));
}

TEST(Roi, UnionHoldsBothAndIgnoresEmptyOnes) {
  EXPECT_EQ(united({0, 0, 2, 2}, {10, 5, 1, 3}), (Roi{0, 0, 11, 8}));
  EXPECT_EQ(united({}, {10, 5, 1, 3}), (Roi{10, 5, 1, 3}));
  EXPECT_EQ(united({10, 5, 1, 3}, {}), (Roi{10, 5, 1, 3}));
}

TEST(Roi, EnlargingKeepsTheCentreAndStaysInTheImage) {
  EXPECT_EQ(enlarged({40, 40, 16, 8}, 0.25, 200, 200), (Roi{38, 39, 20, 10}));
  EXPECT_EQ(enlarged({40, 40, 10, 10}, 0.25, 200, 200), (Roi{38, 38, 14, 14}));  // 1.25 a side, rounded outward
  EXPECT_EQ(enlarged({0, 0, 16, 16}, 0.25, 17, 200), (Roi{0, 0, 17, 18}));
  EXPECT_EQ(enlarged({5, 5, 10, 10}, 0, 200, 200), (Roi{5, 5, 10, 10}));
}

TEST(Roi, ContainsItsFirstButNotItsEndPixels) {
  constexpr Roi kRoi{2, 3, 4, 5};
  EXPECT_TRUE(kRoi.contains(2, 3));
  EXPECT_TRUE(kRoi.contains(5, 7));
  EXPECT_FALSE(kRoi.contains(6, 7));
  EXPECT_FALSE(kRoi.contains(5, 8));
  EXPECT_FALSE(kRoi.contains(1, 3));
}

TEST(ImageView, UsableOnesPassAndOthersAreRefused) {
  const std::array<std::uint8_t, 64> bytes{};
  EXPECT_NO_THROW(require_usable({bytes.data(), 4, 4, 12, PixelFormat::kBgr8}));
  EXPECT_NO_THROW(require_usable({bytes.data(), 4, 4, 16, PixelFormat::kRgb8}));
  EXPECT_NO_THROW(require_usable({bytes.data(), 8, 8, 8, PixelFormat::kGray8}));
  EXPECT_THROW(require_usable({}), Error);
  EXPECT_THROW(require_usable({nullptr, 4, 4, 12, PixelFormat::kBgr8}), Error);
  EXPECT_THROW(require_usable({bytes.data(), 0, 4, 12, PixelFormat::kBgr8}), Error);
  EXPECT_THROW(require_usable({bytes.data(), 4, -1, 12, PixelFormat::kBgr8}), Error);
  EXPECT_THROW(require_usable({bytes.data(), 4, 4, 11, PixelFormat::kBgr8}), Error);
  EXPECT_THROW(require_usable({bytes.data(), 4, 4, -12, PixelFormat::kBgr8}), Error);
  EXPECT_THROW(require_usable({bytes.data(), 32768, 1, 200'000, PixelFormat::kBgr8}), Error);
}

TEST(ImageView, SharesItsPixelsWithMat) {
  cv::Mat big(20, 30, CV_8UC3, cv::Scalar(1, 2, 3));
  const cv::Mat part = big(cv::Rect(5, 6, 10, 8));
  const ImageView view = view_of(part);
  EXPECT_EQ(view.data, big.ptr(6) + 15);
  EXPECT_EQ(view.width, 10);
  EXPECT_EQ(view.height, 8);
  EXPECT_EQ(view.stride, 90);
  EXPECT_EQ(view.format, PixelFormat::kBgr8);
  EXPECT_EQ(view_of(part, PixelFormat::kRgb8).format, PixelFormat::kRgb8);
  EXPECT_EQ(view_of(cv::Mat(2, 2, CV_8UC1)).format, PixelFormat::kGray8);

  const cv::Mat back = mat_of(view);
  EXPECT_EQ(back.data, view.data);
  EXPECT_EQ(back.size(), part.size());
  EXPECT_EQ(back.step, part.step);
  EXPECT_THROW(static_cast<void>(view_of(cv::Mat(2, 2, CV_16UC1))), Error);
  EXPECT_THROW(static_cast<void>(view_of(cv::Mat(2, 2, CV_8UC4))), Error);
}

}  // namespace
}  // namespace cylpose
