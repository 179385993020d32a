#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cylpose/backend.hpp>
#include <cylpose/locate.hpp>
#include <numbers>
#include <vector>

#include "slanted_edge.hpp"

namespace cylpose {
namespace {

using testing::light_of_codes;
using testing::located;
using testing::Rgb;
using testing::SlantedEdge;
using testing::SlantedEdgePicture;

const PartModel kRed{"red", 0.05, 0.4, 340, 20, 0.3, 0.1};
const PartModel kBright{"bright", 0.05, 0.4, 0, 360, 0, 0.4};

std::vector<EdgePixel> edges_in(const ImageView& image, const PartModel& part, Transfer transfer) {
  DetectOptions options;
  options.transfer = transfer;
  return make_backend("serial")->detect(image, image.bounds(), {&part, 1}, options).parts.at(0).edges;
}

struct Accuracy {
  double bias;   // mean distance of the located points from the border, positive inside
  double sigma;  // scatter of single points about it
  double worst;  // largest |mean| of one angle
  int points;
};

// Over angles of the whole circle and five places of the border within a pixel.
Accuracy measured(SlantedEdge edge, const PartModel& part = kRed) {
  double sum = 0;
  double squares = 0;
  double worst = 0;
  int points = 0;
  for (int degrees = 0; degrees < 360; degrees += 36) {
    edge.angle_rad = (degrees + 5) * std::numbers::pi / 180;
    double of_angle = 0;
    int points_of_angle = 0;
    for (const double phase : {-0.4, -0.2, 0.0, 0.2, 0.4}) {
      edge.phase = phase;
      ++edge.seed;
      const SlantedEdgePicture picture(edge);
      const Transfer transfer = edge.linear_codes ? Transfer::kLinear : Transfer::kSrgb;
      for (const EdgePixel& pixel : edges_in(picture.view(), part, transfer)) {
        // Without the picture's own edges, and without specks that noise makes elsewhere.
        constexpr int kRim = 12;
        const bool at_rim =
            pixel.x < kRim || pixel.y < kRim || pixel.x >= edge.size - kRim || pixel.y >= edge.size - kRim;
        if (at_rim || pixel.strength != EdgeStrength::kStrong || std::abs(edge.inside(pixel.x, pixel.y)) > 4) continue;
        const auto [x, y] = located(pixel);
        const double error = edge.inside(x, y);
        of_angle += error;
        squares += error * error;
        ++points_of_angle;
      }
    }
    EXPECT_GT(points_of_angle, 5 * 50) << degrees;
    worst = std::max(worst, std::abs(of_angle / points_of_angle));
    sum += of_angle;
    points += points_of_angle;
  }
  const double bias = sum / points;
  return {bias, std::sqrt(squares / points - bias * bias), worst, points};
}

TEST(Locate, WithAShareOfTheOutsideShadingAndGammaDoNotMatter) {
  struct Case {
    const char* name;
    Rgb background;
    double sigma;  // at noise 1.5; measured, with a fifth to spare
  };
  for (const Case& c :
       {Case{"grey 120", light_of_codes(120, 120, 120), 0.028}, Case{"grey 200", light_of_codes(200, 200, 200), 0.024},
        Case{"grey 60", light_of_codes(60, 60, 60), 0.045}, Case{"white", light_of_codes(255, 255, 255), 0.025},
        Case{"blue", light_of_codes(40, 60, 160), 0.034}, Case{"green", light_of_codes(60, 150, 60), 0.034},
        Case{"brown", light_of_codes(120, 80, 50), 0.05}}) {
    SlantedEdge edge;
    edge.background = c.background;
    const Accuracy noisy = measured(edge);
    EXPECT_LT(std::abs(noisy.bias), 0.015) << c.name;
    EXPECT_LT(noisy.worst, 0.03) << c.name;
    EXPECT_LT(noisy.sigma, c.sigma) << c.name;
    edge.noise = 0;
    const Accuracy clean = measured(edge);
    EXPECT_LT(std::abs(clean.bias), 0.01) << c.name;
    EXPECT_LT(clean.worst, 0.02) << c.name;
    EXPECT_LT(clean.sigma, 0.02) << c.name;
  }
}

TEST(Locate, BlurAndLimbDoNotMoveTheBorder) {
  for (const double blur : {0.3, 0.6, 1.0, 1.5}) {
    for (const double limb : {0.0, 10.0, 200.0}) {
      SlantedEdge edge;
      edge.blur_px = blur;
      edge.limb_px = limb;
      edge.ambient = 0.1;
      const Accuracy accuracy = measured(edge);
      EXPECT_LT(accuracy.worst, 0.035) << "blur " << blur << ", limb " << limb;
      EXPECT_LT(accuracy.sigma, blur > 1 ? 0.1 : 0.05) << "blur " << blur << ", limb " << limb;
    }
  }
}

TEST(Locate, FollowsTheTransferOfTheCamera) {
  SlantedEdge edge;
  edge.linear_codes = true;
  edge.part = {0.8, 0.15, 0.15};
  edge.background = {0.5, 0.5, 0.5};
  edge.noise = 0.5;
  EXPECT_LT(measured(edge).worst, 0.03);

  const SlantedEdgePicture picture(edge);
  double linear = 0;
  double srgb = 0;
  for (const EdgePixel& pixel : edges_in(picture.view(), kRed, Transfer::kLinear)) linear += pixel.offset_256;
  for (const EdgePixel& pixel : edges_in(picture.view(), kRed, Transfer::kSrgb)) srgb += pixel.offset_256;
  EXPECT_GT(std::abs(linear - srgb), 10);
}

// Before black only the part's own light tells where it ends, and how that falls off toward the border is not known.
TEST(Locate, BeforeBlackTheFalloffOfLightHardlyMovesTheBorder) {
  struct Case {
    const char* name;
    double limb_px, ambient, light_deg;
    double bias, sigma;
  };
  for (const Case& c : {Case{"limb 40 px", 40, 0.25, 0, 0.05, 0.1}, Case{"limb 12 px", 12, 0.25, 0, 0.1, 0.1},
                        Case{"limb 200 px", 200, 0.25, 0, 0.06, 0.1}, Case{"no falloff", 0, 1, 0, 0.05, 0.06},
                        Case{"dark limb", 40, 0.05, 0, 0.1, 0.25}, Case{"lit from aside", 40, 0.1, 60, 0.05, 0.06},
                        Case{"terminator near the limb", 40, 0.25, -20, 0.05, 0.15},
                        Case{"terminator that outshines the limb", 20, 0.1, -20, 0.25, 0.3},
                        Case{"the same of a wide part", 40, 0.1, -20, 0.15, 0.3}}) {
    SlantedEdge edge;
    edge.background = light_of_codes(3, 3, 3);
    edge.limb_px = c.limb_px;
    edge.ambient = c.ambient;
    edge.light_rad = c.light_deg * std::numbers::pi / 180;
    const Accuracy accuracy = measured(edge);
    EXPECT_LT(std::abs(accuracy.bias), c.bias) << c.name;
    EXPECT_LT(accuracy.sigma, c.sigma) << c.name;
  }
}

// How bright the outside is right at the border cannot be known then, but where the part's own colour begins can.
TEST(Locate, TextureOfOneHueBehindDoesNotMoveTheBorder) {
  for (const double texture_px : {5.0, 7.0}) {
    SlantedEdge edge;
    edge.background = light_of_codes(90, 90, 90);
    edge.second = light_of_codes(180, 180, 180);
    edge.texture_px = texture_px;
    const Accuracy accuracy = measured(edge);
    EXPECT_LT(std::abs(accuracy.bias), 0.05) << texture_px;
    EXPECT_LT(accuracy.sigma, 0.2) << texture_px;
  }
}

TEST(Locate, GreyImagesHaveNoColorToTellTheOutsideBy) {
  SlantedEdge edge;
  edge.gray = true;
  edge.part = light_of_codes(220, 220, 220);
  edge.background = light_of_codes(40, 40, 40);
  edge.limb_px = 0;
  const Accuracy accuracy = measured(edge, kBright);
  EXPECT_LT(std::abs(accuracy.bias), 0.04);
  EXPECT_LT(accuracy.sigma, 0.04);
}

// One row across a border from grey to red, repeated, without blur: column 20 is the first of the part.
std::vector<std::uint8_t> sharp_border(int width, int height) {
  std::vector<std::uint8_t> bytes;
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      for (const int code : {x < 20 ? 120 : 40, x < 20 ? 120 : 40, x < 20 ? 120 : 200}) {
        bytes.push_back(static_cast<std::uint8_t>(code));
      }
    }
  }
  return bytes;
}

// Inner sides for the part's colour, and one edge pixel to ask about.
std::vector<EdgePixel> with_neighbours(const EdgePixel& asked) {
  std::vector<EdgePixel> edges(10, EdgePixel{20, 8, 400, 0, 0, EdgeStrength::kStrong});
  edges.push_back(asked);
  return edges;
}

TEST(Locate, FindsABorderWithinItsReachAndLeavesOthersAtThePixel) {
  const std::vector<std::uint8_t> bytes = sharp_border(40, 16);
  const ImageView image{bytes.data(), 40, 16, 120, PixelFormat::kBgr8};
  for (int x = 14; x <= 26; ++x) {
    std::vector<EdgePixel> edges =
        with_neighbours({static_cast<std::int16_t>(x), 8, 400, 0, 77, EdgeStrength::kStrong});
    locate_edges(image, image.bounds(), make_gate(kRed), Transfer::kSrgb, edges);
    const double border = 19.5 - x;                  // from the pixel, along the gradient
    if (std::abs(border) == kLocateReach) continue;  // either is right
    const double expected = std::abs(border) <= kLocateReach ? border : 0;
    EXPECT_NEAR(edges.back().offset_256, 256 * expected, 1) << "edge pixel in column " << x;
  }
}

TEST(Locate, SaysWhatToldThePlace) {
  const auto share_told_by = [](EdgeCue cue, double background) {
    SlantedEdge edge;
    edge.background = light_of_codes(background, background, background);
    edge.angle_rad = 0.3;
    const SlantedEdgePicture picture(edge);
    const std::vector<EdgePixel> edges = edges_in(picture.view(), kRed, Transfer::kSrgb);
    return static_cast<double>(std::ranges::count(edges, cue, &EdgePixel::cue)) / static_cast<double>(edges.size());
  };
  EXPECT_GT(share_told_by(EdgeCue::kShare, 140), 0.9);
  EXPECT_GT(share_told_by(EdgeCue::kLimb, 2), 0.9);

  // Before black, light that rises evenly as from a terminator.
  std::vector<std::uint8_t> bytes;
  for (int i = 0; i < 40 * 16; ++i) {
    const int red = std::max(0, 8 * (i % 40 - 19));
    for (const int code : {0, 0, red}) bytes.push_back(static_cast<std::uint8_t>(code));
  }
  const ImageView ramp{bytes.data(), 40, 16, 120, PixelFormat::kBgr8};
  std::vector<EdgePixel> edges = with_neighbours({20, 8, 400, 0, 0, EdgeStrength::kStrong});
  locate_edges(ramp, ramp.bounds(), make_gate(kRed), Transfer::kLinear, edges);
  EXPECT_EQ(edges.back().cue, EdgeCue::kSlope);
}

// What the sensor cuts off would put the border inside. Where a colour is left, that one tells.
TEST(Locate, KnowsAnOverexposedBackground) {
  SlantedEdge edge;
  const auto cue_told = [&](EdgeCue cue) {
    const std::vector<EdgePixel> edges = edges_in(SlantedEdgePicture(edge).view(), kRed, Transfer::kSrgb);
    return static_cast<double>(std::ranges::count(edges, cue, &EdgePixel::cue)) / static_cast<double>(edges.size());
  };
  edge.background = {3, 3, 3};
  EXPECT_GT(cue_told(EdgeCue::kClipped), 0.9);
  EXPECT_GT(measured(edge).bias, 0.2);
  for (const Rgb& sky : {Rgb{0.5, 0.6, 3}, Rgb{0.4, 2, 0.5}}) {
    edge.background = sky;
    EXPECT_GT(cue_told(EdgeCue::kShare), 0.9);
    EXPECT_LT(measured(edge).worst, 0.03);
  }
}

// A strip of the part, the lens's blur on both of its borders, between two greys: where it is thinner than the filter
// looks, the other border bends its place. In the upper rows it is wide, which tells the part's colour.
TEST(Locate, NothingTellsThePlaceOfASliver) {
  const auto cue_of_strip = [](double thickness_px) {
    constexpr int kColumns = 48;
    constexpr double kFrom = 20.2;
    constexpr double kSigmaPx = 0.7;
    const auto step = [&](double from, int x) {
      return 0.5 * std::erfc((from - x) / (std::numbers::sqrt2 * kSigmaPx));
    };
    const Rgb left = light_of_codes(140, 140, 140);
    const Rgb part = light_of_codes(200, 40, 40);
    const Rgb right = light_of_codes(110, 110, 110);
    std::vector<std::uint8_t> bytes;
    for (int y = 0; y < 16; ++y) {
      for (int x = 0; x < kColumns; ++x) {
        const double begun = step(kFrom, x);
        const double ended = step(kFrom + (y < 6 ? 20 : thickness_px), x);
        for (const std::size_t c : {2U, 1U, 0U}) {
          const double light = (1 - begun) * left[c] + (begun - ended) * part[c] + ended * right[c];
          bytes.push_back(static_cast<std::uint8_t>(std::lround(testing::code_of_light(light))));
        }
      }
    }
    const ImageView image{bytes.data(), kColumns, 16, 3 * kColumns, PixelFormat::kBgr8};
    std::vector<EdgePixel> edges{{21, 2, 400, 0, 0, EdgeStrength::kStrong}, {21, 11, 400, 0, 0, EdgeStrength::kStrong}};
    locate_edges(image, image.bounds(), make_gate(kRed), Transfer::kSrgb, edges);
    EXPECT_EQ(edges.front().cue, EdgeCue::kShare);
    const EdgePixel& edge = edges.back();
    if (edge.cue == EdgeCue::kShare) {
      EXPECT_NEAR(21 + edge.offset_256 / 256.0, kFrom, 0.02) << thickness_px << " px";
    }
    return edge.cue;
  };
  EXPECT_EQ(cue_of_strip(2), EdgeCue::kNone);
  EXPECT_EQ(cue_of_strip(3), EdgeCue::kNone);
  EXPECT_EQ(cue_of_strip(7), EdgeCue::kShare);
  EXPECT_EQ(cue_of_strip(20), EdgeCue::kShare);
}

TEST(Locate, AnEdgeWithoutGradientStaysAtItsPixel) {
  const std::vector<std::uint8_t> bytes = sharp_border(40, 16);
  const ImageView image{bytes.data(), 40, 16, 120, PixelFormat::kBgr8};
  std::vector<EdgePixel> edges = with_neighbours({20, 8, 0, 0, 77, EdgeStrength::kWeak, EdgeCue::kShare});
  locate_edges(image, image.bounds(), make_gate(kRed), Transfer::kSrgb, edges);
  EXPECT_EQ(edges.back().offset_256, 0);
  EXPECT_EQ(edges.back().cue, EdgeCue::kNone);
  edges.clear();
  locate_edges(image, image.bounds(), make_gate(kRed), Transfer::kSrgb, edges);
  EXPECT_TRUE(edges.empty());
}

// Dirt and clipped pixels on an inner side have another colour than the part and must not bend it.
TEST(Locate, OnlyUnclippedPixelsOfTheGateTellThePartsColor) {
  struct Case {
    const char* name;
    std::array<std::uint8_t, 3> bgr;
  };
  for (const Case& c : {Case{"dirt", {60, 60, 80}}, Case{"clipped red", {110, 110, 255}}}) {
    std::vector<std::uint8_t> bytes = sharp_border(40, 16);
    for (const std::size_t x : {23U, 24U})
      std::ranges::copy(c.bgr, bytes.begin() + static_cast<std::ptrdiff_t>(8 * 120 + 3 * x));
    const ImageView image{bytes.data(), 40, 16, 120, PixelFormat::kBgr8};
    std::vector<EdgePixel> edges{{20, 8, 400, 0, 0, EdgeStrength::kStrong}, {20, 4, 400, 0, 0, EdgeStrength::kStrong}};
    locate_edges(image, image.bounds(), make_gate(kRed), Transfer::kSrgb, edges);
    EXPECT_NEAR(edges[1].offset_256, -128, 1) << c.name;
  }
}

}  // namespace
}  // namespace cylpose
