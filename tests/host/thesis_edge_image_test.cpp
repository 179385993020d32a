// Thesis algorithm 5.3: from the colour image to the edges of the mask.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cylpose/image_cv.hpp>
#include <cylpose/thesis.hpp>
#include <opencv2/imgproc.hpp>

namespace cylpose {
namespace {

PartModel part_of_hue(double lo_deg, double hi_deg) {
  return {"part", 0.05, 0.4, lo_deg, hi_deg, 0.3, 0.2};
}

bool passes(const PartModel& part, const cv::Scalar& bgr) {
  const cv::Mat image(1, 1, CV_8UC3, bgr);
  return thesis_gate(view_of(image), {0, 0, 1, 1}, part).pixels.at(0) != 0;
}

// Full colours of the hue circle's corners, in OpenCV's order.
const cv::Scalar kRed(0, 0, 255);
const cv::Scalar kYellow(0, 255, 255);
const cv::Scalar kGreen(0, 255, 0);
const cv::Scalar kBlue(255, 0, 0);
const cv::Scalar kMagenta(255, 0, 255);

TEST(ThesisGate, TakesTheHueRange) {
  const PartModel blue = part_of_hue(200, 260);
  EXPECT_TRUE(passes(blue, kBlue));
  for (const cv::Scalar& other : {kRed, kYellow, kGreen, kMagenta}) EXPECT_FALSE(passes(blue, other));
}

TEST(ThesisGate, HueRangeWraps) {
  const PartModel red = part_of_hue(345, 15);
  EXPECT_TRUE(passes(red, kRed));
  EXPECT_TRUE(passes(red, cv::Scalar(40, 0, 255)));  // 351 degrees
  EXPECT_TRUE(passes(red, cv::Scalar(0, 40, 255)));  // 9 degrees
  EXPECT_FALSE(passes(red, cv::Scalar(100, 0, 255)));
  EXPECT_FALSE(passes(red, kYellow));
  EXPECT_FALSE(passes(red, kBlue));
}

TEST(ThesisGate, TopOfTheCircleIsWrittenAsZero) {
  EXPECT_TRUE(passes(part_of_hue(300, 360), cv::Scalar(1, 0, 255)));  // 359.8 degrees
  EXPECT_FALSE(passes(part_of_hue(300, 358), kRed));
  EXPECT_TRUE(passes(part_of_hue(359.5, 0.5), kRed));
  EXPECT_FALSE(passes(part_of_hue(359.5, 0.5), kMagenta));
  // All but a sliver, in both ways of writing it.
  for (const cv::Scalar& color : {kRed, kYellow, kGreen, kBlue, kMagenta}) {
    EXPECT_TRUE(passes(part_of_hue(0, 359.9), color));
    EXPECT_TRUE(passes(part_of_hue(30.2, 30.1), color));
  }
}

TEST(ThesisGate, GreysHaveNoHue) {
  PartModel red = part_of_hue(345, 15);
  red.min_saturation = 0;
  red.min_value = 0;
  EXPECT_FALSE(passes(red, cv::Scalar::all(128)));
  EXPECT_FALSE(passes(red, cv::Scalar::all(0)));
  PartModel any = part_of_hue(0, 360);
  any.min_saturation = 0;
  EXPECT_TRUE(passes(any, cv::Scalar::all(128)));
}

TEST(ThesisGate, FloorsOfSaturationAndValue) {
  const PartModel blue = part_of_hue(200, 260);  // floors 0.3 and 0.2
  EXPECT_TRUE(passes(blue, cv::Scalar(200, 135, 135)));
  EXPECT_FALSE(passes(blue, cv::Scalar(200, 145, 145)));
  EXPECT_TRUE(passes(blue, cv::Scalar(51, 0, 0)));
  EXPECT_FALSE(passes(blue, cv::Scalar(50, 0, 0)));
}

TEST(ThesisGate, KnowsTheOrderOfColoursAndGreyImages) {
  const cv::Mat image(1, 1, CV_8UC3, kBlue);
  const PartModel blue = part_of_hue(200, 260);
  EXPECT_EQ(thesis_gate(view_of(image, PixelFormat::kBgr8), {0, 0, 1, 1}, blue).pixels.at(0), 255);
  EXPECT_EQ(thesis_gate(view_of(image, PixelFormat::kRgb8), {0, 0, 1, 1}, blue).pixels.at(0), 0);
  const cv::Mat gray = (cv::Mat_<std::uint8_t>(1, 2) << 50, 51);
  EXPECT_THAT(thesis_gate(view_of(gray), {0, 0, 2, 1}, blue).pixels, testing::ElementsAre(0, 255));
}

TEST(ThesisGate, MaskIsOfTheSearchRegion) {
  cv::Mat image(20, 30, CV_8UC3, cv::Scalar::all(0));
  image.at<cv::Vec3b>(7, 12) = {255, 0, 0};
  const Mask mask = thesis_gate(view_of(image), {10, 5, 8, 4}, part_of_hue(200, 260));
  EXPECT_EQ(mask.roi, (Roi{10, 5, 8, 4}));
  ASSERT_EQ(mask.pixels.size(), 32U);
  EXPECT_EQ(std::count(mask.pixels.begin(), mask.pixels.end(), 255), 1);
  EXPECT_EQ(mask.pixels[2 * 8 + 2], 255);
}

Mask mask_with(const Roi& roi, const Roi& filled) {
  Mask mask{roi, {}};
  for (int y = roi.y; y < roi.bottom(); ++y) {
    for (int x = roi.x; x < roi.right(); ++x) mask.pixels.push_back(filled.contains(x, y) ? 255 : 0);
  }
  return mask;
}

TEST(ThesisMorphology, RemovesSpecksAndRestoresTheRest) {
  const Roi roi{0, 0, 20, 15};
  Mask mask = mask_with(roi, {5, 4, 8, 6});
  const Mask clean = mask;
  mask.pixels[1] = 255;                                       // a speck
  mask.pixels[12 * 20 + 3] = mask.pixels[12 * 20 + 4] = 255;  // two
  thesis_morphology(&mask);
  EXPECT_EQ(mask.pixels, clean.pixels);
}

TEST(ThesisMorphology, BorderOfTheMaskDoesNotErode) {
  Mask mask = mask_with({0, 0, 10, 8}, {6, 0, 4, 8});
  const Mask before = mask;
  thesis_morphology(&mask);
  EXPECT_EQ(mask.pixels, before.pixels);
}

TEST(ThesisStatistics, AreThoseOfTheFrame) {
  const Roi filled{107, 54, 9, 30};
  RegionStatistics expected;
  for (int y = filled.y; y < filled.bottom(); ++y) {
    for (int x = filled.x; x < filled.right(); ++x) expected.add(x, y);
  }
  expected.box = filled;
  EXPECT_EQ(thesis_statistics(mask_with({100, 50, 40, 60}, filled)), expected);
  EXPECT_EQ(thesis_statistics(mask_with({100, 50, 40, 60}, {})), RegionStatistics{});
}

TEST(ThesisCanny, FollowsTheOutlineOfTheMask) {
  const Roi filled{107, 54, 20, 30};
  const Mask edges = thesis_canny(mask_with({100, 50, 40, 60}, filled), filled);
  EXPECT_EQ(edges.roi, (Roi{105, 52, 24, 34}));
  int count = 0;
  for (int y = edges.roi.y; y < edges.roi.bottom(); ++y) {
    for (int x = edges.roi.x; x < edges.roi.right(); ++x) {
      const auto index = static_cast<std::size_t>((y - edges.roi.y) * edges.roi.width + x - edges.roi.x);
      if (edges.pixels[index] == 0) continue;
      ++count;
      // Next to the border of the rectangle, inside or outside.
      const Roi outer{filled.x - 1, filled.y - 1, filled.width + 2, filled.height + 2};
      const Roi inner{filled.x + 1, filled.y + 1, filled.width - 2, filled.height - 2};
      EXPECT_TRUE(outer.contains(x, y) && !inner.contains(x, y)) << x << ' ' << y;
    }
  }
  EXPECT_NEAR(count, 2 * (20 + 30), 4);
}

TEST(ThesisCanny, BorderOfTheSearchedAreaIsNoEdge) {
  const Roi roi{0, 0, 40, 30};
  const Roi filled{25, 0, 15, 30};  // from top to bottom and to the right border
  const Mask edges = thesis_canny(mask_with(roi, filled), filled);
  for (int y = 0; y < edges.roi.height; ++y) {
    for (int x = 0; x < edges.roi.width; ++x) {
      const bool is_left_side = edges.roi.x + x == 24;
      EXPECT_EQ(edges.pixels[static_cast<std::size_t>(y * edges.roi.width + x)] != 0, is_left_side) << x << ' ' << y;
    }
  }
}

}  // namespace
}  // namespace cylpose
