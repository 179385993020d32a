#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cylpose/backend.hpp>
#include <numbers>
#include <random>
#include <string>
#include <thread>

#include "slanted_edge.hpp"
#include "test_images.hpp"

namespace cylpose {
namespace {

using testing::located;
using testing::random_image;
using testing::SlantedEdge;
using testing::SlantedEdgePicture;
using testing::TestImage;

DetectOptions with_masks() {
  DetectOptions options;
  options.with_mask = true;
  return options;
}

PartEdges detect(const char* backend, const ImageView& image, const PartModel& part) {
  return make_backend(backend)->detect(image, image.bounds(), {&part, 1}, with_masks()).parts.at(0);
}

double share_of_different(const Mask& a, const Mask& b) {
  EXPECT_EQ(a.pixels.size(), b.pixels.size());
  std::size_t different = 0;
  for (std::size_t i = 0; i < a.pixels.size(); ++i) different += a.pixels[i] != b.pixels[i] ? 1 : 0;
  return static_cast<double>(different) / static_cast<double>(a.pixels.size());
}

// Colours in squares of 3 x 3 pixels, which pass erosion and dilation unchanged where the neighbours differ.
TestImage patches_of_random_colors(std::mt19937& random, PixelFormat format) {
  TestImage image(600, 600, format);
  std::uniform_int_distribution<int> code(0, 255);
  for (int y = 0; y < image.height; y += 3) {
    for (int x = 0; x < image.width; x += 3) {
      const std::array<int, 3> color{code(random), code(random), code(random)};
      for (int i = 0; i < 9; ++i) {
        for (std::size_t c = 0; c < 3; ++c) {
          image.pixel(x + i % 3, y + i / 3)[c] = static_cast<std::uint8_t>(color[c]);
        }
      }
    }
  }
  return image;
}

TEST(OpencvBackend, MasksOfRandomColorsDifferInLessThan15InAThousandPixels) {
  std::mt19937 random(1);
  struct Range {
    double lo, hi;
  };
  for (const Range& range :
       {Range{0, 60}, Range{345, 15}, Range{90, 150}, Range{200, 260}, Range{300, 60}, Range{10, 300}, Range{350, 340},
        Range{0, 180}, Range{300, 360}, Range{0, 360}, Range{100, 99.6}}) {
    for (const PixelFormat format : {PixelFormat::kBgr8, PixelFormat::kRgb8}) {
      const TestImage image = patches_of_random_colors(random, format);
      const PartModel part{"part", 0.05, 0.4, range.lo, range.hi, 0.2, 0.1};
      const PartEdges serial = detect("serial", image.view(), part);
      const PartEdges opencv = detect("opencv", image.view(), part);
      EXPECT_LT(share_of_different(serial.mask, opencv.mask), 0.015) << range.lo << ".." << range.hi;
      EXPECT_GT(serial.region.m00, 1000);
    }
  }
}

TEST(OpencvBackend, GreyImagesGiveTheSameMaskAndStatistics) {
  std::mt19937 random(2);
  const PartModel part{"bright", 0.05, 0.4, 0, 60, 0, 0.4};
  for (const int width : {1, 2, 63, 64, 65, 101}) {
    const TestImage image = random_image(width, 57, random, PixelFormat::kGray8, 5);
    const PartEdges serial = detect("serial", image.view(), part);
    const PartEdges opencv = detect("opencv", image.view(), part);
    EXPECT_EQ(serial.mask.pixels, opencv.mask.pixels) << width;
    EXPECT_EQ(serial.region, opencv.region) << width;
  }
}

TEST(OpencvBackend, StatisticsAreThoseOfItsMaskInFrameCoordinates) {
  std::mt19937 random(3);
  const TestImage image = random_image(140, 110, random);
  const PartModel part{"most", 0.05, 0.4, 10, 290, 0.1, 0};
  const Roi search{21, 33, 90, 60};
  const EdgeField field = make_backend("opencv")->detect(image.view(), search, {&part, 1}, with_masks());
  RegionStatistics expected;
  for (int y = 0; y < search.height; ++y) {
    for (int x = 0; x < search.width; ++x) {
      if (field.parts[0].mask.pixels[static_cast<std::size_t>(y * search.width + x)] == 0) continue;
      expected.add(search.x + x, search.y + y);
      expected.box = united(expected.box, {search.x + x, search.y + y, 1, 1});
    }
  }
  EXPECT_GT(expected.m00, 500);
  EXPECT_EQ(field.parts[0].region, expected);
}

TEST(OpencvBackend, BordersAreFoundWhereSerialFindsThem) {
  const PartModel part{"red", 0.05, 0.4, 340, 20, 0.3, 0.1};
  for (int degrees = 0; degrees < 360; degrees += 15) {
    SlantedEdge edge;
    edge.angle_rad = degrees * std::numbers::pi / 180;
    edge.seed = static_cast<unsigned>(degrees);
    const SlantedEdgePicture picture(edge);
    for (const char* backend : {"serial", "opencv"}) {
      double sum = 0;
      int points = 0;
      for (const EdgePixel& pixel : detect(backend, picture.view(), part).edges) {
        const bool at_rim = pixel.x < 12 || pixel.y < 12 || pixel.x >= 84 || pixel.y >= 84;
        if (at_rim || pixel.strength != EdgeStrength::kStrong) continue;
        const auto [x, y] = located(pixel);
        sum += edge.inside(x, y);
        ++points;
      }
      // Four directions leave up to two rows of pixels on a diagonal border.
      EXPECT_GE(points, 60) << backend << " at " << degrees;
      EXPECT_LT(points, 150) << backend << " at " << degrees;
      EXPECT_LT(std::abs(sum / points), 0.03) << backend << " at " << degrees;
    }
  }
}

TEST(OpencvBackend, NothingOutsideTheSearchRegionMatters) {
  std::mt19937 random(4);
  TestImage image = random_image(150, 120, random);
  const PartModel part{"most", 0.05, 0.4, 10, 290, 0.1, 0};
  const Roi search{31, 22, 77, 65};
  const TestImage before = image;
  const auto run = [&] { return make_backend("opencv")->detect(image.view(), search, {&part, 1}, with_masks()); };
  const PartEdges expected = run().parts[0];
  testing::fill_with_noise(image, random);
  for (int y = search.y; y < search.bottom(); ++y) {
    std::copy_n(before.view().row(y) + std::ptrdiff_t{3} * search.x, 3 * search.width, image.pixel(search.x, y));
  }
  const PartEdges found = run().parts[0];
  EXPECT_GT(expected.edges.size(), 20U);
  EXPECT_EQ(found.edges, expected.edges);
  EXPECT_EQ(found.region, expected.region);
  EXPECT_EQ(found.mask.pixels, expected.mask.pixels);
}

TEST(OpencvBackend, TakesAnyHueAndEmptySearchRegionsAndNamesItsStages) {
  std::mt19937 random(5);
  const TestImage image = random_image(60, 50, random);
  for (const double saturation : {0.0, 0.5}) {
    const PartModel any{"any", 0.05, 0.4, 0, 360, saturation, 0.4};
    EXPECT_LT(share_of_different(detect("serial", image.view(), any).mask, detect("opencv", image.view(), any).mask),
              0.015);
  }
  const PartModel part{"red", 0.05, 0.4, 340, 20, 0.3, 0.1};
  const auto backend = make_backend("opencv");
  EXPECT_TRUE(backend->detect(image.view(), {70, 0, 5, 5}, {&part, 1}, {}).searched.empty());
  std::vector<std::string> stages;
  for (const StageTime& time : backend->detect(image.view(), image.view().bounds(), {&part, 1}, {}).times) {
    stages.emplace_back(time.stage);
  }
  EXPECT_EQ(stages, (std::vector<std::string>{"gate", "morphology", "statistics", "edges", "locate"}));
}

TEST(OpencvBackend, MayBeUsedFromSeveralThreads) {
  std::mt19937 random(6);
  const TestImage image = random_image(130, 90, random);
  const PartModel part{"most", 0.05, 0.4, 10, 290, 0.1, 0};
  const auto backend = make_backend("opencv");
  const auto run = [&] { return backend->detect(image.view(), image.view().bounds(), {&part, 1}, {}).parts[0]; };
  const PartEdges expected = run();
  const auto repeat = [&] {
    for (int i = 0; i < 20; ++i) {
      const PartEdges found = run();
      EXPECT_EQ(found.edges, expected.edges);
      EXPECT_EQ(found.region, expected.region);
    }
  };
  std::thread other(repeat);
  repeat();
  other.join();
}

}  // namespace
}  // namespace cylpose
