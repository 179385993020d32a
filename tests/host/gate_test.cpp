#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cylpose/gate.hpp>
#include <random>
#include <vector>

namespace cylpose {
namespace {

constexpr int kColors = 200'000;

PartModel part_of(double lo, double hi, double saturation = 0, double value = 0) {
  return {"part", 0.05, 0.4, lo, hi, saturation, value};
}

struct Rgb {
  int r, g, b;
};

Rgb random_color(std::mt19937& random) {
  std::uniform_int_distribution<int> code(0, 255);
  return {code(random), code(random), code(random)};
}

// The textbook definition. Hue in degrees; of a grey it has no meaning.
struct Hsv {
  double hue, saturation, value;
};

Hsv hsv_of(const Rgb& c) {
  const double high = std::max({c.r, c.g, c.b});
  const double low = std::min({c.r, c.g, c.b});
  const double chroma = high - low;
  double hue = 0;
  if (chroma > 0) {
    if (high == c.r) {
      hue = std::fmod((c.g - c.b) / chroma + 6, 6);
    } else if (high == c.g) {
      hue = (c.b - c.r) / chroma + 2;
    } else {
      hue = (c.r - c.g) / chroma + 4;
    }
  }
  return {60 * hue, high > 0 ? chroma / high : 0, high / 255};
}

// Distance on the hue circle, 0..180.
double between(double a, double b) {
  const double turn = std::fmod(std::abs(a - b), 360);
  return std::min(turn, 360 - turn);
}

bool in_range(double hue, double lo, double hi) {
  return lo <= hi ? hue >= lo && hue <= hi : hue >= lo || hue <= hi;
}

struct Range {
  double lo, hi;
};

const std::vector<Range>& whole_degree_ranges() {
  static const std::vector<Range> ranges{{0, 60},  {345, 15},  {300, 60}, {90, 150},  {10, 11},   {200, 260}, {0, 180},
                                         {180, 0}, {10, 300},  {300, 10}, {350, 340}, {0, 359},   {359, 0},   {1, 360},
                                         {59, 61}, {119, 121}, {60, 240}, {270, 90},  {123, 304}, {37, 216},  {0, 1}};
  return ranges;
}

TEST(Gate, WholeDegreesAgreeWithTheHsvDefinition) {
  std::mt19937 random(1);
  for (const Range& range : whole_degree_ranges()) {
    const ColorGate gate = make_gate(part_of(range.lo, range.hi));
    int wrong = 0;
    int compared = 0;
    for (int i = 0; i < kColors; ++i) {
      const Rgb c = random_color(random);
      const Hsv hsv = hsv_of(c);
      const bool tie = between(hsv.hue, range.lo) < 1e-9 || between(hsv.hue, range.hi) < 1e-9;
      if (tie || hsv.saturation == 0) continue;
      ++compared;
      wrong += passes(gate, c.r, c.g, c.b) != in_range(hsv.hue, range.lo, range.hi) ? 1 : 0;
    }
    EXPECT_GT(compared, 0.97 * kColors);
    EXPECT_EQ(wrong, 0) << range.lo << ".." << range.hi;
  }
}

TEST(Gate, AnyRangeAndFloorsAgreeAwayFromTheirBorders) {
  std::mt19937 random(2);
  std::uniform_real_distribution<double> degrees(0, 360);
  std::uniform_real_distribution<double> floor(0, 0.8);
  int wrong = 0;
  int passed = 0;
  int compared = 0;
  for (int i = 0; i < kColors; ++i) {
    const PartModel part = part_of(degrees(random), degrees(random), floor(random), floor(random));
    const Rgb c = random_color(random);
    const Hsv hsv = hsv_of(c);
    const bool tie = between(hsv.hue, part.hue_lo_deg) < 0.47 || between(hsv.hue, part.hue_hi_deg) < 0.47 ||
                     std::abs(hsv.saturation - part.min_saturation) < 0.5 / 256 ||
                     std::abs(hsv.value - part.min_value) < 1e-9;
    if (tie || hsv.saturation == 0) continue;
    ++compared;
    const bool expected = in_range(hsv.hue, part.hue_lo_deg, part.hue_hi_deg) && hsv.saturation > part.min_saturation &&
                          hsv.value > part.min_value;
    passed += expected ? 1 : 0;
    const ColorGate gate = make_gate(part);
    wrong += passes(gate, c.r, c.g, c.b) != expected ? 1 : 0;
  }
  EXPECT_GT(compared, 0.95 * kColors);
  EXPECT_GT(passed, 0.2 * kColors);
  EXPECT_EQ(wrong, 0);
}

TEST(Gate, AnyRangeAgreesFor999InAThousandColorsOverall) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> degrees(0, 360);
  int wrong = 0;
  for (int i = 0; i < kColors; ++i) {
    const Range range{degrees(random), degrees(random)};
    const Rgb c = random_color(random);
    const Hsv hsv = hsv_of(c);
    const bool expected = hsv.saturation > 0 && in_range(hsv.hue, range.lo, range.hi);
    wrong += passes(make_gate(part_of(range.lo, range.hi)), c.r, c.g, c.b) != expected ? 1 : 0;
  }
  EXPECT_LT(wrong, kColors / 1000);
}

TEST(Gate, CoefficientsKeepProductsWithin16Bits) {
  std::mt19937 random(4);
  std::uniform_real_distribution<double> degrees(0, 360);
  for (int i = 0; i < 10'000; ++i) {
    const ColorGate gate = make_gate(part_of(degrees(random), degrees(random)));
    for (const int n : {gate.lo_r, gate.lo_b, gate.lo_r + gate.lo_b, gate.hi_r, gate.hi_b, gate.hi_r + gate.hi_b}) {
      EXPECT_LE(std::abs(n), 64);
    }
    for (const int n : {gate.response_r, gate.response_b, gate.response_r + gate.response_b}) {
      EXPECT_LE(std::abs(n), 69);
    }
    for (const int n : {gate.aside_r, gate.aside_b, gate.aside_r + gate.aside_b}) EXPECT_LE(std::abs(n), 128);
  }
}

TEST(Gate, GreysAndBlackPassOnlyWhereAnyHueDoes) {
  for (const Range& range : whole_degree_ranges()) {
    const ColorGate gate = make_gate(part_of(range.lo, range.hi));
    for (int code = 0; code < 256; ++code) {
      EXPECT_FALSE(passes(gate, code, code, code)) << range.lo << ".." << range.hi;
    }
  }
  const ColorGate any = make_gate(part_of(0, 360, 0, 0.5));
  EXPECT_EQ(any.any_hue, 1);
  EXPECT_FALSE(passes(any, 127, 127, 127));
  EXPECT_TRUE(passes(any, 128, 128, 128));
  EXPECT_TRUE(passes(any, 128, 0, 77));
  EXPECT_TRUE(passes(make_gate(part_of(0, 360)), 0, 0, 0));
}

TEST(Gate, FloorsIncludeTheirOwnValue) {
  const ColorGate gate = make_gate(part_of(330, 30, 0.5, 0.2));
  EXPECT_EQ(gate.value, 51);
  EXPECT_EQ(gate.saturation_256, 128);
  EXPECT_TRUE(passes(gate, 51, 0, 0));
  EXPECT_FALSE(passes(gate, 50, 0, 0));
  EXPECT_TRUE(passes(gate, 200, 100, 100));
  EXPECT_FALSE(passes(gate, 200, 101, 101));
  EXPECT_FALSE(passes(make_gate(part_of(330, 30, 1, 0)), 200, 1, 1));
  EXPECT_TRUE(passes(make_gate(part_of(330, 30, 1, 0)), 200, 0, 0));
}

TEST(Gate, GreyImagesAreGatedByValueAlone) {
  const ColorGate gate = make_gate(part_of(100, 140, 0.5, 0.5));
  EXPECT_FALSE(passes_gray(gate, 127));
  EXPECT_TRUE(passes_gray(gate, 128));
}

Rgb hexagon(int hue) {
  const double f = hue % 60 / 60.0;
  const int up = static_cast<int>(std::lround(255 * f));
  const int down = 255 - up;
  const std::vector<Rgb> walk{{255, up, 0}, {down, 255, 0}, {0, 255, up}, {0, down, 255}, {up, 0, 255}, {255, 0, down}};
  return walk[static_cast<std::size_t>(hue / 60 % 6)];
}

TEST(Gate, ResponseFallsToBothSidesOfTheMidHue) {
  for (int mid = 0; mid < 360; ++mid) {
    const ColorGate gate = make_gate(part_of((mid + 335) % 360, (mid + 25) % 360));
    for (const int side : {-1, 1}) {
      const auto at = [&](int away) {
        const Rgb c = hexagon((mid + side * away + 360) % 360);
        return response(gate, c.r, c.g, c.b);
      };
      EXPECT_LT(at(25), 210) << mid;  // a background at the end of the range stands apart,
      EXPECT_GT(at(25), 60) << mid;   // a part there is still seen
      EXPECT_LT(at(45), 75) << mid;
      EXPECT_EQ(at(60), 0) << mid;
    }
  }
}

TEST(Gate, ResponseIsFullForTheMidHueAndZeroForGreysAndOppositeHues) {
  for (int mid = 0; mid < 360; ++mid) {
    const ColorGate gate = make_gate(part_of((mid + 340) % 360, (mid + 20) % 360));
    const Rgb c = hexagon(mid);
    EXPECT_NEAR(response(gate, c.r, c.g, c.b), 255, 6) << mid;
    EXPECT_NEAR(response(gate, c.r / 2, c.g / 2, c.b / 2), 127, 3) << mid;
    const Rgb opposite = hexagon((mid + 180) % 360);
    EXPECT_EQ(response(gate, opposite.r, opposite.g, opposite.b), 0) << mid;
    EXPECT_EQ(response(gate, 200, 200, 200), 0);
  }
}

TEST(Gate, ResponseOfAnyHueIsWhatItsFloorsLookAt) {
  EXPECT_EQ(response(make_gate(part_of(0, 360, 0, 0.5)), 10, 200, 30), 200);
  EXPECT_EQ(response(make_gate(part_of(0, 360, 0.5, 0)), 10, 200, 30), 190);
}

}  // namespace
}  // namespace cylpose
