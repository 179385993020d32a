#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cylpose/backend.hpp>
#include <cylpose/error.hpp>
#include <functional>
#include <random>
#include <string>
#include <thread>
#include <utility>

#include "naive_stages.hpp"
#include "test_images.hpp"

namespace cylpose {
namespace {

using testing::cropped;
using testing::fill_with_noise;
using testing::NaiveStages;
using testing::random_image;
using testing::TestImage;

const std::vector<PartModel>& parts() {
  static const std::vector<PartModel> models{{"red", 0.05, 0.4, 300, 60, 0.2, 0.1},
                                             {"most", 0.05, 0.4, 10, 290, 0.1, 0},
                                             {"green", 0.05, 0.4, 80, 170, 0.3, 0.2},
                                             {"bright", 0.05, 0.4, 0, 360, 0, 0.4}};
  return models;
}

DetectOptions with_masks() {
  DetectOptions options;
  options.with_mask = true;
  return options;
}

EdgeField detect(const ImageView& image, const Roi& search, std::span<const PartModel> models = parts(),
                 const DetectOptions& options = with_masks()) {
  return make_backend("serial")->detect(image, search, models, options);
}

void expect_equal(const PartEdges& a, const PartEdges& b) {
  EXPECT_EQ(a.region, b.region);
  EXPECT_EQ(a.edges, b.edges);
  EXPECT_EQ(a.mask.pixels, b.mask.pixels);
}

// The edge field of the same pixels with their origin elsewhere.
PartEdges moved(PartEdges part, int dx, int dy) {
  RegionStatistics& r = part.region;
  r.m20 += 2 * dx * r.m10 + std::int64_t{dx} * dx * r.m00;
  r.m11 += dy * r.m10 + dx * r.m01 + std::int64_t{dx} * dy * r.m00;
  r.m02 += 2 * dy * r.m01 + std::int64_t{dy} * dy * r.m00;
  r.m10 += dx * r.m00;
  r.m01 += dy * r.m00;
  if (!r.box.empty()) r.box = {r.box.x + dx, r.box.y + dy, r.box.width, r.box.height};
  for (EdgePixel& edge : part.edges) {
    edge.x = static_cast<std::int16_t>(edge.x + dx);
    edge.y = static_cast<std::int16_t>(edge.y + dy);
  }
  return part;
}

struct Size {
  int width, height;
};
constexpr std::array kSizes{Size{1, 1},  Size{1, 9},   Size{9, 1},   Size{2, 2},   Size{3, 3},    Size{5, 4},
                            Size{63, 7}, Size{64, 33}, Size{65, 31}, Size{127, 5}, Size{101, 103}};
constexpr std::array kFormats{PixelFormat::kBgr8, PixelFormat::kRgb8, PixelFormat::kGray8};

std::vector<EdgePixel> not_located(std::vector<EdgePixel> edges) {
  for (EdgePixel& edge : edges) {
    edge.offset_256 = 0;
    edge.cue = EdgeCue::kNone;
  }
  return edges;
}

TEST(SerialBackend, AgreesWithTheNaiveStagesOnAnySizeAndFormat) {
  std::mt19937 random(1);
  std::size_t edges = 0;
  std::int64_t area = 0;
  for (const Size& size : kSizes) {
    for (const PixelFormat format : kFormats) {
      const TestImage image = random_image(size.width, size.height, random, format, size.width % 3 * 7);
      const ImageView view = image.view();
      const EdgeField field = detect(view, view.bounds());
      ASSERT_EQ(field.parts.size(), parts().size());
      for (std::size_t i = 0; i < parts().size(); ++i) {
        SCOPED_TRACE(std::to_string(size.width) + "x" + std::to_string(size.height) + " " + parts()[i].name);
        const NaiveStages naive(view, view.bounds(), parts()[i], with_masks());
        EXPECT_EQ(field.parts[i].mask.roi, view.bounds());
        EXPECT_EQ(field.parts[i].mask.pixels, naive.mask());
        EXPECT_EQ(field.parts[i].region, naive.region());
        const std::vector<EdgePixel> found = not_located(field.parts[i].edges);
        EXPECT_EQ(found, naive.edges());
        edges += found.size();
        area += field.parts[i].region.m00;
      }
    }
  }
  EXPECT_GT(edges, 1000U);
  EXPECT_GT(area, 10'000);
}

TEST(SerialBackend, AgreesWithTheNaiveStagesInsideARegionAndWithOtherThresholds) {
  std::mt19937 random(2);
  DetectOptions options = with_masks();
  options.edge_low = 20;
  options.edge_high = 60;
  for (int i = 0; i < 10; ++i) {
    const TestImage image = random_image(90, 70, random);
    const Roi search{13, 7, 40 + i, 50 - i};
    const EdgeField field = detect(image.view(), search, parts(), options);
    EXPECT_EQ(field.searched, search);
    const NaiveStages naive(image.view(), search, parts()[0], options);
    EXPECT_EQ(field.parts[0].mask.pixels, naive.mask());
    EXPECT_EQ(field.parts[0].region, naive.region());
    const std::vector<EdgePixel> found = not_located(field.parts[0].edges);
    EXPECT_EQ(found, naive.edges());
  }
}

TEST(SerialBackend, NothingOutsideTheSearchRegionMatters) {
  std::mt19937 random(3);
  TestImage image = random_image(150, 120, random);
  const Roi search{31, 22, 77, 65};
  const TestImage inner = cropped(image.view(), search);
  const EdgeField alone = detect(inner.view(), inner.view().bounds());
  for (int round = 0; round < 3; ++round) {
    const EdgeField field = detect(image.view(), search);
    std::size_t edges = 0;
    for (std::size_t i = 0; i < parts().size(); ++i) {
      edges += field.parts[i].edges.size();
      expect_equal(field.parts[i], moved(alone.parts[i], search.x, search.y));
    }
    EXPECT_GT(edges, 100U);
    fill_with_noise(image, random);
    for (int y = 0; y < search.height; ++y) {
      std::copy_n(inner.view().row(y), 3 * search.width, image.pixel(search.x, search.y + y));
    }
  }
}

TEST(SerialBackend, SeveralPartsAtOnceEqualOneAtATime) {
  std::mt19937 random(4);
  const TestImage image = random_image(120, 80, random);
  const EdgeField together = detect(image.view(), image.view().bounds());
  for (std::size_t i = 0; i < parts().size(); ++i) {
    expect_equal(together.parts[i], detect(image.view(), image.view().bounds(), {&parts()[i], 1}).parts[0]);
  }
}

TEST(SerialBackend, RgbAndBgrAreTheSamePicture) {
  std::mt19937 random(5);
  TestImage bgr = random_image(120, 80, random);
  TestImage rgb = bgr;
  rgb.format = PixelFormat::kRgb8;
  for (int y = 0; y < rgb.height; ++y) {
    for (int x = 0; x < rgb.width; ++x) std::swap(rgb.pixel(x, y)[0], rgb.pixel(x, y)[2]);
  }
  const EdgeField a = detect(bgr.view(), bgr.view().bounds());
  const EdgeField b = detect(rgb.view(), rgb.view().bounds());
  for (std::size_t i = 0; i < parts().size(); ++i) expect_equal(a.parts[i], b.parts[i]);
}

// A square of a pure colour on grey; equal gradients on both sides of its border.
TEST(SerialBackend, EdgesOfASquareAreItsOutermostPixelsAndPointInward) {
  TestImage image(40, 40);
  std::ranges::fill(image.bytes, std::uint8_t{90});
  for (int y = 10; y < 30; ++y) {
    for (int x = 10; x < 30; ++x) image.pixel(x, y)[2] = 200, image.pixel(x, y)[1] = image.pixel(x, y)[0] = 30;
  }
  const EdgeField field = detect(image.view(), image.view().bounds());
  const PartEdges& red = field.parts[0];
  EXPECT_EQ(red.region.m00, 400);
  EXPECT_EQ(red.region.box, (Roi{10, 10, 20, 20}));
  EXPECT_EQ(red.edges.size(), 76U);  // the ring of the square, corners too
  for (const EdgePixel& edge : red.edges) {
    EXPECT_TRUE(edge.x == 10 || edge.x == 29 || edge.y == 10 || edge.y == 29) << edge.x << "," << edge.y;
    EXPECT_GT((19.5 - edge.x) * edge.gx + (19.5 - edge.y) * edge.gy, 0);
    EXPECT_EQ(edge.strength, EdgeStrength::kStrong);
    const bool beside_corner = (edge.x < 16 || edge.x > 23) && (edge.y < 16 || edge.y > 23);
    if (beside_corner) continue;
    EXPECT_NEAR(edge.offset_256, -128, 2);  // the border is half a pixel outside
  }
}

TEST(SerialBackend, AnEdgeOfTheSearchRegionIsNoEdgeOfThePart) {
  TestImage image(30, 30);
  for (int y = 0; y < 30; ++y) {
    for (int x = 0; x < 30; ++x) image.pixel(x, y)[2] = 200;
  }
  const EdgeField field = detect(image.view(), {5, 5, 20, 20});
  EXPECT_EQ(field.parts[0].region.m00, 400);
  EXPECT_TRUE(field.parts[0].edges.empty());
}

TEST(SerialBackend, FindsNothingInNothing) {
  TestImage image(30, 30);
  std::ranges::fill(image.bytes, std::uint8_t{77});
  const PartModel red = parts()[0];
  EdgeField field = detect(image.view(), image.view().bounds(), {&red, 1});
  EXPECT_EQ(field.parts[0].region, RegionStatistics{});
  EXPECT_TRUE(field.parts[0].edges.empty());

  field = detect(image.view(), {40, 40, 10, 10});  // beside the image
  EXPECT_TRUE(field.searched.empty());
  ASSERT_EQ(field.parts.size(), parts().size());
  EXPECT_EQ(field.parts[3].region, RegionStatistics{});

  EXPECT_TRUE(detect(image.view(), image.view().bounds(), {}).parts.empty());
}

TEST(SerialBackend, CutsTheSearchRegionToTheImage) {
  std::mt19937 random(6);
  const TestImage image = random_image(50, 40, random);
  const EdgeField field = detect(image.view(), {-20, -10, 500, 400});
  EXPECT_EQ(field.searched, image.view().bounds());
}

TEST(SerialBackend, GivesMasksOnRequestOnlyAndNamesItsStages) {
  std::mt19937 random(7);
  const TestImage image = random_image(50, 40, random);
  const EdgeField field = detect(image.view(), image.view().bounds(), parts(), {});
  EXPECT_TRUE(field.parts[0].mask.pixels.empty());
  std::vector<std::string> stages;
  for (const StageTime& time : field.times) {
    stages.emplace_back(time.stage);
    EXPECT_GE(time.milliseconds, 0);
  }
  EXPECT_EQ(stages, (std::vector<std::string>{"gate", "morphology", "statistics", "edges", "locate"}));
}

TEST(SerialBackend, MayBeUsedFromSeveralThreads) {
  std::mt19937 random(8);
  const TestImage first = random_image(130, 90, random);
  const TestImage second = random_image(130, 90, random);
  const auto backend = make_backend("serial");
  const auto run = [&](const TestImage& image) {
    return backend->detect(image.view(), image.view().bounds(), parts(), with_masks());
  };
  const EdgeField expected_first = run(first);
  const EdgeField expected_second = run(second);
  const auto repeat = [&](const TestImage& image, const EdgeField& expected) {
    for (int i = 0; i < 20; ++i) {
      const EdgeField field = run(image);
      for (std::size_t part = 0; part < parts().size(); ++part) expect_equal(field.parts[part], expected.parts[part]);
    }
  };
  std::thread other(repeat, std::cref(first), std::cref(expected_first));
  repeat(second, expected_second);
  other.join();
}

TEST(SerialBackend, RefusesUnusableImagesAndOptions) {
  const TestImage image(10, 10);
  DetectOptions options;
  options.edge_low = 30;
  EXPECT_THROW(static_cast<void>(detect(image.view(), image.view().bounds(), parts(), options)), Error);
  ImageView no_pixels = image.view();
  no_pixels.data = nullptr;
  EXPECT_THROW(static_cast<void>(detect(no_pixels, image.view().bounds())), Error);
}

}  // namespace
}  // namespace cylpose
