#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cmath>
#include <cylpose/error.hpp>
#include <cylpose/gate.hpp>
#include <cylpose/tune.hpp>
#include <random>
#include <string>

#include "test_images.hpp"

namespace cylpose {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using testing::TestImage;

constexpr Roi kSample{10, 10, 40, 30};

// Full colour of a hue, mixed with white to the saturation and darkened to the value; noise of sigma 3.
TestImage image_of(double hue_deg, double saturation, double value, PixelFormat format = PixelFormat::kBgr8) {
  TestImage image(60, 50, format);
  std::mt19937 random(7);
  std::normal_distribution<double> noise(0, 3);
  const auto level = [&](double peak) {  // of the primary colour at that hue
    const double away = std::abs(std::remainder(hue_deg - peak, 360)) / 60;
    return 255 * value * (1 - saturation * (1 - std::clamp(2 - away, 0.0, 1.0)));
  };
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      std::uint8_t* pixel = image.pixel(x, y);
      const bool bgr = format == PixelFormat::kBgr8;
      const auto put = [&](int channel, double code) {
        pixel[channel] = static_cast<std::uint8_t>(std::clamp(std::lround(code + noise(random)), 0L, 255L));
      };
      put(bgr ? 2 : 0, level(0));
      put(1, level(120));
      put(bgr ? 0 : 2, level(240));
    }
  }
  return image;
}

void paint(TestImage& image, const Roi& roi, int code) {
  for (int y = roi.y; y < roi.bottom(); ++y)
    std::fill_n(image.pixel(roi.x, y), 3 * roi.width, static_cast<std::uint8_t>(code));
}

PartModel part_with(const ColorSuggestion& color) {
  return {"part", 0.05, 0.4, color.hue_lo_deg, color.hue_hi_deg, color.min_saturation, color.min_value};
}

std::string error_of(const ImageView& image, const Roi& sample) {
  try {
    static_cast<void>(suggest_color(image, sample));
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::kInput);
    return error.what();
  }
  return "no error";
}

TEST(SuggestColor, HoldsTheSampleAndNotMuchMoreAllAroundTheCircle) {
  for (int hue = 0; hue < 360; hue += 15) {
    const TestImage image = image_of(hue, 0.7, 0.7, hue % 2 == 0 ? PixelFormat::kBgr8 : PixelFormat::kRgb8);
    const ColorSuggestion color = suggest_color(image.view(), kSample);
    for (const double end : {color.hue_lo_deg, color.hue_hi_deg}) {
      EXPECT_GE(end, 0);
      EXPECT_LT(end, 360);
      EXPECT_EQ(end, std::floor(end));
    }
    EXPECT_NEAR(std::remainder(color.hue_lo_deg - hue, 360), -11, 5) << hue;
    EXPECT_NEAR(std::remainder(color.hue_hi_deg - hue, 360), 11, 5) << hue;
    EXPECT_NEAR(color.min_saturation, 0.5, 0.05);
    EXPECT_NEAR(color.min_value, 0.34, 0.03);

    const ColorGate gate = make_gate(part_with(color));
    const bool bgr = image.format == PixelFormat::kBgr8;
    int passed = 0;
    for (int y = kSample.y; y < kSample.bottom(); ++y) {
      for (int x = kSample.x; x < kSample.right(); ++x) {
        const std::uint8_t* p = image.view().row(y) + 3 * x;
        passed += passes(gate, p[bgr ? 2 : 0], p[1], p[bgr ? 0 : 2]) ? 1 : 0;
      }
    }
    EXPECT_GT(passed, 0.99 * kSample.width * kSample.height) << hue;
  }
}

TEST(SuggestColor, RangeOfRedWraps) {
  const TestImage image = image_of(0, 0.8, 0.8);
  const ColorSuggestion color = suggest_color(image.view(), kSample);
  EXPECT_GT(color.hue_lo_deg, 340);
  EXPECT_LT(color.hue_hi_deg, 20);
}

TEST(SuggestColor, AHighlightAndAFewForeignPixelsDoNotMatter) {
  TestImage image = image_of(120, 0.7, 0.7);
  const ColorSuggestion before = suggest_color(image.view(), kSample);
  paint(image, {12, 12, 20, 10}, 250);  // a highlight, a sixth
  for (int i = 0; i < 12; ++i) image.pixel(15 + i, 35)[0] = 255, image.pixel(15 + i, 35)[1] = 0;  // blue, a hundredth
  const ColorSuggestion after = suggest_color(image.view(), kSample);
  EXPECT_NEAR(after.hue_lo_deg, before.hue_lo_deg, 2);
  EXPECT_NEAR(after.hue_hi_deg, before.hue_hi_deg, 2);
  EXPECT_NEAR(after.min_saturation, before.min_saturation, 0.03);
  EXPECT_NEAR(after.min_value, before.min_value, 0.03);
}

TEST(SuggestColor, OnlyTheSampleCounts) {
  TestImage image = image_of(200, 0.6, 0.6);
  const ColorSuggestion before = suggest_color(image.view(), kSample);
  paint(image, {0, 0, 60, 10}, 90);
  paint(image, {50, 0, 10, 50}, 90);
  const ColorSuggestion after = suggest_color(image.view(), kSample);
  EXPECT_EQ(after.hue_lo_deg, before.hue_lo_deg);
  EXPECT_EQ(after.hue_hi_deg, before.hue_hi_deg);
}

TEST(SuggestColor, ErrorsNameValueAndRemedy) {
  TestImage image = image_of(200, 0.6, 0.6);
  EXPECT_THAT(error_of(image.view(), {10, 10, 0, 5}), AllOf(HasSubstr("10,10,0,5"), HasSubstr("empty")));
  EXPECT_THAT(error_of(image.view(), {50, 10, 20, 5}),
              AllOf(HasSubstr("50,10,20,5"), HasSubstr("60 x 50"), HasSubstr("choose")));
  EXPECT_THAT(error_of(image.view(), {-1, 0, 5, 5}), HasSubstr("not inside"));
  EXPECT_THAT(error_of(image.view(), {100, 100, 5, 5}), HasSubstr("not inside"));

  TestImage two_colors = image;
  for (int y = 0; y < 50; ++y) {
    for (int x = 0; x < 30; ++x) std::swap(two_colors.pixel(x, y)[0], two_colors.pixel(x, y)[2]);
  }
  EXPECT_THAT(error_of(two_colors.view(), kSample), AllOf(HasSubstr("spread"), HasSubstr("part alone")));

  paint(image, image.view().bounds(), 128);
  EXPECT_THAT(error_of(image.view(), kSample), AllOf(HasSubstr("100 %"), HasSubstr("no hue")));
  paint(image, image.view().bounds(), 0);
  EXPECT_THAT(error_of(image.view(), kSample), HasSubstr("no hue"));
  const TestImage gray(60, 50, PixelFormat::kGray8);
  EXPECT_THAT(error_of(gray.view(), kSample), HasSubstr("colour image"));
}

TEST(PartsFileText, IsYamlWithEveryKey) {
  const PartModel part{"red: \"candle\" #1", 0.0395, 0.27, 345, 15, 0.5, 0.25};
  const YAML::Node entry = YAML::Load(parts_file_text(part))["parts"][0];
  EXPECT_EQ(entry["name"].as<std::string>(), part.name);
  EXPECT_EQ(entry["radius_m"].as<double>(), 0.0395);
  EXPECT_EQ(entry["height_m"].as<double>(), 0.27);
  EXPECT_EQ(entry["hue_deg"][0].as<double>(), 345);
  EXPECT_EQ(entry["hue_deg"][1].as<double>(), 15);
  EXPECT_EQ(entry["min_saturation"].as<double>(), 0.5);
  EXPECT_EQ(entry["min_value"].as<double>(), 0.25);
}

TEST(PartsFileText, MissingSizesAreMarkedAndNotInvented) {
  const std::string text = parts_file_text({"part", 0, 0, 345, 15, 0.5, 0.25});
  EXPECT_THAT(text, AllOf(HasSubstr("radius_m: 0  # fill in"), HasSubstr("height_m: 0  # fill in")));
  EXPECT_EQ(YAML::Load(text)["parts"][0]["radius_m"].as<double>(), 0);
}

TEST(MaskPicture, ShowsTheSampleAndDarkensOutsideTheMask) {
  TestImage image(20, 10);
  std::ranges::fill(image.bytes, std::uint8_t{100});
  Mask mask{image.view().bounds(), std::vector<std::uint8_t>(200)};
  mask.pixels[5 * 20 + 7] = 255;
  const cv::Mat picture = mask_picture(image.view(), mask, {4, 3, 6, 4});
  ASSERT_EQ(picture.size(), cv::Size(40, 10));
  EXPECT_EQ(picture.at<cv::Vec3b>(2, 3), cv::Vec3b(255, 255, 255));  // around the sample
  EXPECT_EQ(picture.at<cv::Vec3b>(7, 10), cv::Vec3b(255, 255, 255));
  EXPECT_EQ(picture.at<cv::Vec3b>(3, 4), cv::Vec3b(100, 100, 100));  // the sample
  EXPECT_EQ(picture.at<cv::Vec3b>(5, 27), cv::Vec3b(100, 100, 100));
  EXPECT_EQ(picture.at<cv::Vec3b>(5, 28), cv::Vec3b(25, 25, 25));

  TestImage rgb = image;
  rgb.format = PixelFormat::kRgb8;
  rgb.pixel(0, 0)[0] = 200;
  EXPECT_EQ(mask_picture(rgb.view(), mask, {4, 3, 6, 4}).at<cv::Vec3b>(0, 0), cv::Vec3b(100, 100, 200));
}

}  // namespace
}  // namespace cylpose
