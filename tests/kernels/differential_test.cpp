// opencl = serial, bit for bit: masks, statistics, edges and where they lie.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdlib>
#include <functional>
#include <iostream>
#include <map>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "comparison.hpp"
#include "guarded_pixels.hpp"
#include "host/slanted_edge.hpp"
#include "host/test_images.hpp"

namespace cylpose {
namespace {

using testing::Compared;
using testing::expect_equal;
using testing::four_parts;
using testing::GuardedPixels;
using testing::random_image;
using testing::TestImage;

constexpr std::array kFormats{PixelFormat::kBgr8, PixelFormat::kRgb8, PixelFormat::kGray8};

// How the kernels are run: as on CPUs; as on GPUs, with many work-items in a group, each with little to do; in
// strips on two devices (one device twice does as well), with seams where they never are in practice; and on copies, as
// devices without shared memory need them.
struct Tuning {
  const char* name;
  int group_size = 0;
  int span_words = 0;
  const char* device = "";
  int strip_rows = 0;
  bool copy_frames = false;
};

std::ostream& operator<<(std::ostream& out, const Tuning& tuning) {
  return out << tuning.name;
}

class Differential : public ::testing::TestWithParam<Tuning> {
 protected:
  // One for all tests of a tuning: its buffers have seen other sizes before.
  static OpenclBackend& opencl() {
    const Tuning& tuning = GetParam();
    auto& backend = backends()[tuning.name];
    if (backend == nullptr) {
      OpenclOptions options;
      options.group_size = tuning.group_size;
      options.span_words = tuning.span_words;
      options.device = tuning.device;
      options.strip_rows = tuning.strip_rows;
      options.copy_frames = tuning.copy_frames;
      backend = make_opencl_backend(options);
    }
    return *backend;
  }

  // Before the end of the process: drivers may be gone by the time static objects are destroyed.
  static void TearDownTestSuite() { backends().clear(); }

  static Compared compare(const ImageView& image, const Roi& search, const DetectOptions& options = {},
                          const std::vector<PartModel>& parts = four_parts()) {
    SCOPED_TRACE(std::to_string(image.width) + " x " + std::to_string(image.height) + " format " +
                 std::to_string(static_cast<int>(image.format)) + " search " + std::to_string(search.x) + "," +
                 std::to_string(search.y) + " " + std::to_string(search.width) + "x" + std::to_string(search.height));
    return expect_equal(opencl(), image, search, parts, options);
  }

 private:
  static std::map<std::string, std::unique_ptr<OpenclBackend>>& backends() {
    static std::map<std::string, std::unique_ptr<OpenclBackend>> all;
    return all;
  }
};

INSTANTIATE_TEST_SUITE_P(
    Kernels, Differential,
    ::testing::Values(Tuning{"default"}, Tuning{"groups_of_4", 4, 1}, Tuning{"groups_of_64", 64, 3},
                      Tuning{"strips_of_two_devices", 0, 0, "0,0", 5}, Tuning{"strips_of_one_row", 0, 0, "0,0", 1},
                      Tuning{"copied_in_strips", 0, 0, "0,0", 7, true}, Tuning{"copied", 0, 0, "", 0, true}),
    [](const auto& tuning) { return tuning.param.name; });

TEST_P(Differential, AnySizeAndFormat) {
  std::mt19937 random(11);
  Compared sum;
  // Around vectors (16), words (64), blocks of words (512) and their sums; primes; single rows and columns.
  constexpr std::array kWidths{1,  2,  3,  4,  5,  11,  12,  15,  16,  17,  31,  32,  33,
                               47, 48, 63, 64, 65, 101, 127, 128, 129, 511, 512, 513, 577};
  constexpr std::array kHeights{1, 2, 3, 4, 5, 7, 9, 16, 31};
  std::size_t turn = 0;
  for (const int width : kWidths) {
    for (const int height : kHeights) {
      // All formats in turn; of the smallest images all at once.
      for (std::size_t i = 0; i < (width * height < 100 ? kFormats.size() : 1); ++i) {
        const TestImage image = random_image(width, height, random, kFormats[turn++ % kFormats.size()], width % 5);
        const Compared compared = compare(image.view(), image.view().bounds());
        sum.edges += compared.edges;
        sum.mask_pixels += compared.mask_pixels;
      }
    }
  }
  EXPECT_GT(sum.edges, 5000U);
  EXPECT_GT(sum.mask_pixels, 50'000);
}

// Enough to take every path once; what Oclgrind, thousands of times slower than a device, has time for.
TEST_P(Differential, SmallFrames) {
  std::cout << "on " << opencl().devices().at(0).name << '\n';
  std::mt19937 random(15);
  std::size_t edges = 0;
  for (const PixelFormat format : kFormats) {
    for (const auto& [width, height] : {std::pair{1, 1}, std::pair{15, 6}, std::pair{67, 12}, std::pair{130, 7}}) {
      const TestImage image = random_image(width, height, random, format, 5);
      edges += compare(image.view(), image.view().bounds()).edges;
      edges += compare(image.view(), {width / 3, height / 3, width / 2, height}).edges;
    }
  }
  EXPECT_GT(edges, 300U);
}

TEST_P(Differential, SearchRegionsInALargerImageSeeNothingOutside) {
  std::mt19937 random(12);
  std::size_t edges = 0;
  for (const PixelFormat format : kFormats) {
    const TestImage image = random_image(203, 97, random, format, 13);
    const auto number = [&](int low, int high) { return std::uniform_int_distribution<int>(low, high)(random); };
    for (int i = 0; i < 20; ++i) {
      const Roi search{number(-20, 190), number(-20, 90), number(1, 220), number(1, 110)};
      edges += compare(image.view(), search).edges;
    }
  }
  EXPECT_GT(edges, 1000U);
}

TEST_P(Differential, NoByteBeyondThePixelsIsRead) {
  std::mt19937 random(13);
  for (const int width : {1, 5, 15, 16, 17, 63, 64, 65, 79, 80, 130}) {
    for (const PixelFormat format : kFormats) {
      const TestImage image = random_image(width, 13, random, format, width % 7);
      for (const auto end : {GuardedPixels::Touching::kFirst, GuardedPixels::Touching::kLast}) {
        const GuardedPixels guarded(image.view(), end);
        compare(guarded.view(), guarded.view().bounds());
      }
    }
  }
}

// One colour everywhere but where `inside` says so.
TestImage drawn(int width, int height, const std::function<bool(int x, int y)>& inside) {
  TestImage image(width, height);
  constexpr std::array<std::uint8_t, 3> kRed{20, 30, 220};
  constexpr std::array<std::uint8_t, 3> kBlue{150, 90, 40};
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) std::ranges::copy(inside(x, y) ? kRed : kBlue, image.pixel(x, y));
  }
  return image;
}

TEST_P(Differential, StripsWithTheirHaloAreTheFrame) {
  std::mt19937 random(21);
  const std::unique_ptr<Backend> serial = make_backend("serial");
  DetectOptions options;
  options.locate = false;
  for (const PixelFormat format : kFormats) {
    const TestImage image = random_image(131, 61, random, format, 3);
    const Roi search{5, 3, 120, 55};
    const EdgeField whole = serial->detect(image.view(), search, four_parts(), options);
    for (const int rows : {1, 4, 13, 55}) {
      std::vector<std::vector<EdgePixel>> edges(four_parts().size());
      std::vector<std::int64_t> areas(four_parts().size());
      for (int first = 0; first < search.height; first += rows) {
        const Roi tall = intersection({5, 3 + first - kStripHalo, 120, rows + 2 * kStripHalo}, search);
        options.rows = {3 + first - tall.y, std::min(3 + first + rows, search.bottom()) - tall.y};
        const EdgeField strip = opencl().detect(image.view(), tall, four_parts(), options);
        const EdgeField expected = serial->detect(image.view(), tall, four_parts(), options);
        for (std::size_t part = 0; part < areas.size(); ++part) {
          EXPECT_EQ(strip.parts[part].region, expected.parts[part].region);
          const std::vector<EdgePixel>& found = strip.parts[part].edges;
          edges[part].insert(edges[part].end(), found.begin(), found.end());
          areas[part] += strip.parts[part].region.m00;
        }
      }
      options.rows = {};
      for (std::size_t part = 0; part < areas.size(); ++part) {
        EXPECT_EQ(edges[part], whole.parts[part].edges);
        EXPECT_EQ(areas[part], whole.parts[part].region.m00);
      }
    }
  }
}

TEST_P(Differential, PatternsThatMaskLogicMayGetWrong) {
  constexpr int kWidth = 197;
  constexpr int kHeight = 61;
  const auto chebyshev = [](int x, int y, int cx, int cy) { return std::max(std::abs(x - cx), std::abs(y - cy)); };
  std::vector<std::pair<std::string, std::function<bool(int, int)>>> patterns{
      {"empty", [](int, int) { return false; }},
      {"full", [](int, int) { return true; }},
      {"checkerboard", [](int x, int y) { return (x + y) % 2 == 0; }},
      {"checkerboard of 3", [](int x, int y) { return (x / 3 + y / 3) % 2 == 0; }},
      {"frame of the rectangle", [&](int x, int y) { return x < 3 || y < 3 || x >= kWidth - 3 || y >= kHeight - 3; }},
      {"all but a pixel", [](int x, int y) { return x != 64 || y != 30; }},
      {"a diagonal", [](int x, int y) { return std::abs(x - 3 * y) < 4; }},
  };
  for (int x : {0, 1, 62, 63, 64, 65, 127, 128, kWidth - 2, kWidth - 1}) {
    patterns.emplace_back("square at column " + std::to_string(x),
                          [=](int px, int py) { return chebyshev(px, py, x, 30) <= 1; });
    patterns.emplace_back("square too small at column " + std::to_string(x),
                          [=](int px, int py) { return px >= x && px < x + 2 && py >= 30 && py < 32; });
    patterns.emplace_back("edge at column " + std::to_string(x), [=](int px, int) { return px <= x; });
  }
  for (int y : {0, 1, 2, kHeight / 2, kHeight - 2, kHeight - 1}) {
    patterns.emplace_back("square at row " + std::to_string(y),
                          [=](int px, int py) { return chebyshev(px, py, 64, y) <= 1; });
    patterns.emplace_back("edge at row " + std::to_string(y), [=](int, int py) { return py >= y; });
  }
  for (int period : {1, 2, 3, 4, 5, 8}) {
    patterns.emplace_back("columns of " + std::to_string(period), [=](int x, int) { return x / period % 2 == 0; });
    patterns.emplace_back("rows of " + std::to_string(period), [=](int, int y) { return y / period % 2 == 0; });
  }
  std::size_t edges = 0;
  for (const auto& [name, inside] : patterns) {
    SCOPED_TRACE(name);
    const TestImage image = drawn(kWidth, kHeight, inside);
    edges += compare(image.view(), image.view().bounds()).edges;
  }
  EXPECT_GT(edges, 5000U);
}

// All ways in which a border is located, at all angles: by the outside's share, before texture, before black; before
// the dark side of a limb, inside of which a terminator outshines it, and without any colour.
TEST_P(Differential, BordersBeforeAllKindsOfBackground) {
  using testing::light_of_codes;
  const std::vector<PartModel> red{{"red", 0.05, 0.4, 340, 20, 0.3, 0.1}};
  const std::vector<PartModel> bright{{"bright", 0.05, 0.4, 0, 360, 0, 0.3}};
  std::vector<testing::SlantedEdge> cases(8);
  cases[1].background = light_of_codes(90, 90, 90);
  cases[1].second = light_of_codes(200, 180, 170);
  cases[1].texture_px = 7;
  cases[2].background = light_of_codes(2, 2, 2);
  cases[3] = cases[2];
  cases[3].ambient = 0.02;
  cases[3].noise = 5;
  cases[4].blur_px = 2.5;
  cases[4].noise = 8;
  cases[6] = cases[2];
  cases[6].light_rad = -0.35;
  cases[7] = cases[6];
  cases[7].limb_px = 20;
  cases[7].ambient = 0.1;
  cases[5].gray = true;
  cases[5].part = light_of_codes(200, 200, 200);
  cases[5].background = light_of_codes(40, 40, 40);
  Compared sum;
  for (testing::SlantedEdge& edge : cases) {
    for (int degrees = 0; degrees < 360; degrees += 24) {
      edge.angle_rad = degrees * 3.14159 / 180;
      edge.size = 40;
      ++edge.seed;
      const testing::SlantedEdgePicture picture(edge);
      const ImageView image = picture.view();
      sum.edges += compare(image, image.bounds(), {}, edge.gray ? bright : red).edges;
    }
  }
  EXPECT_GT(sum.edges, 3000U);
}

TEST_P(Differential, AllHuesInAllRanges) {
  // Every colour of a fine grid through the cube, in blocks that survive the erosion.
  constexpr int kSteps = 12;
  constexpr int kBlock = 4;
  TestImage image(kSteps * kSteps * kBlock, kSteps * kBlock);
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      const int red = x / kBlock % kSteps;
      const int green = x / kBlock / kSteps;
      const int blue = y / kBlock;
      const auto code = [](int step) { return static_cast<std::uint8_t>(step * 255 / (kSteps - 1)); };
      std::ranges::copy(std::array{code(blue), code(green), code(red)}, image.pixel(x, y));
    }
  }
  std::int64_t area = 0;
  for (int lo = 0; lo < 360; lo += 45) {
    std::vector<PartModel> parts;
    for (const int width : {1, 30, 120, 179, 180, 181, 270, 359, 360}) {
      parts.push_back({std::to_string(lo) + "+" + std::to_string(width), 0.05, 0.4, static_cast<double>(lo),
                       static_cast<double>(width == 360 ? lo + 360 : (lo + width) % 360), width % 2 * 0.3, 0.1});
    }
    area += compare(image.view(), image.view().bounds(), {}, parts).mask_pixels;
  }
  EXPECT_GT(area, 100'000);
}

TEST_P(Differential, OptionsAndExtremeParts) {
  std::mt19937 random(14);
  const TestImage image = random_image(150, 70, random);
  const std::vector<PartModel> extremes{{"floors 1", 0.05, 0.4, 0, 120, 1, 1},
                                        {"all", 0.05, 0.4, 0, 360, 0, 0},
                                        {"chroma", 0.05, 0.4, 0, 360, 0.5, 0},
                                        {"no floors", 0.05, 0.4, 200, 20, 0, 0}};
  std::size_t edges = 0;
  for (const Transfer transfer : {Transfer::kSrgb, Transfer::kLinear}) {
    for (const auto& [low, high] : {std::pair{1, 1}, std::pair{6, 16}, std::pair{40, 90}, std::pair{255, 255}}) {
      DetectOptions options;
      options.transfer = transfer;
      options.edge_low = low;
      options.edge_high = high;
      edges += compare(image.view(), image.view().bounds(), options).edges;
      edges += compare(image.view(), image.view().bounds(), options, extremes).edges;
    }
  }
  EXPECT_GT(edges, 3000U);
}

TEST_P(Differential, MoreEdgesThanExpected) {
  // Single red pixels would be eroded, so a pattern of crosses: edges nearly everywhere, far more than an outline has.
  const TestImage image = drawn(511, 300, [](int x, int y) { return x % 7 < 3 || y % 7 < 3; });
  const std::vector<PartModel> part{four_parts()[0]};
  EXPECT_GT(compare(image.view(), image.view().bounds(), {}, part).edges, 2U * (511 + 300));
  // And again, and few again: the larger buffer stays.
  compare(image.view(), image.view().bounds(), {}, part);
  compare(image.view(), {10, 10, 20, 20}, {}, part);
}

TEST_P(Differential, MoreLightThanHalfASumHolds) {
  // Red of code 220 is light 47000 of 65535, twice an edge: beyond 46,000 edges the low 32 bits overflow.
  const TestImage image = drawn(1200, 600, [](int x, int) { return x % 16 < 8; });
  EXPECT_GT(compare(image.view(), image.view().bounds(), {}, {four_parts()[0]}).edges, 60'000U);
}

}  // namespace
}  // namespace cylpose
