#include "location.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "requirements.hpp"

namespace cylpose::bench {
namespace {

LocationCase usual() {
  return location_cases().front();
}

// Evenly lit, linear codes: the border is a step of known height under a Gaussian and, head on, a box one pixel wide.
// The derivative is a bell of sigma^2 = blur^2 + 1/12 to a good approximation, its square's integral height^2 / (2
// sqrt(pi) sigma).
TEST(EdgeBound, IsThatOfABlurredStep) {
  LocationCase step = usual();
  step.edge.linear_codes = true;
  step.edge.limb_px = 0;
  step.edge.blur_px = 1.5;
  step.edge.noise = 3;
  step.edge.part = {200 / 255.0, 40 / 255.0, 40 / 255.0};
  step.edge.background = {140 / 255.0, 140 / 255.0, 140 / 255.0};
  const double sigma = std::sqrt(1.5 * 1.5 + 1.0 / 12);
  const double squares = 60 * 60 + 2 * 100 * 100;
  const double expected = std::sqrt((9 + 1.0 / 12) * 2 * std::sqrt(std::numbers::pi) * sigma / squares);
  EXPECT_NEAR(edge_bound(step, 0), expected, 0.01 * expected);
  EXPECT_NEAR(edge_bound(step, 90), expected, 0.01 * expected);
  // Along the diagonal a row has more of the border.
  EXPECT_NEAR(edge_bound(step, 45), expected * std::sqrt(std::sqrt(0.5)), 0.02 * expected);
}

// An unbiased estimate from the pixels of one row, made with all that the bound assumes to be known, has the bound's
// scatter: the weighted sum of the differences from the known profile.
TEST(EdgeBound, IsReachedByTheMatchedEstimate) {
  LocationCase one = usual();
  one.edge.linear_codes = true;
  one.edge.limb_px = 0;
  one.edge.part = {0.8, 0.2, 0.2};
  one.edge.background = {0.5, 0.5, 0.5};
  const testing::SlantedEdgePicture clean(one.edge);
  const int row = one.edge.size / 2;
  std::mt19937 random(2);
  std::normal_distribution<double> noise(0, std::sqrt(one.edge.noise * one.edge.noise + 1.0 / 12));
  double squares = 0;
  constexpr int kRuns = 4000;
  for (int run = 0; run < kRuns; ++run) {
    double information = 0;
    double weighted = 0;
    for (int x = row - 8; x <= row + 8; ++x) {
      const double depth = one.edge.inside(x, row);
      for (std::size_t c = 0; c < 3; ++c) {
        const double slope = 255 * (clean.light_at(depth + 0.01)[c] - clean.light_at(depth - 0.01)[c]) / 0.02;
        information += slope * slope;
        weighted += slope * noise(random);
      }
    }
    squares += std::pow(weighted / information, 2);
  }
  EXPECT_NEAR(std::sqrt(squares / kRuns) / edge_bound(one, 0), 1, 0.06);
}

TEST(Location, ScattersMoreThanTheBoundAndHardlyBeside) {
  const Location location = measured(usual(), true);
  EXPECT_EQ(location.level, kUsual);
  EXPECT_GT(location.points, 500);
  EXPECT_GT(location.pooled_px, location.bound_px);
  EXPECT_GT(location.pooled_px, location.sigma_px);  // points share pixels with their neighbours
  EXPECT_LT(location.pooled_px, 3 * location.bound_px);
  EXPECT_LT(location.mean_abs_bias_px, 0.02);
  EXPECT_LE(location.mean_abs_bias_px, location.worst_bias_px);
}

// Pictures in the camera's codes taken for linear ones: borders are found, at the wrong place.
TEST(Location, SeesABias) {
  LocationCase shifted = usual();
  shifted.sharpening = 2;
  const Location location = measured(shifted, false);
  EXPECT_GT(location.mean_abs_bias_px, 0.1);
  const std::vector<Requirement> requirements = location_requirements({&location, 1});
  EXPECT_FALSE(requirements.at(0).is_met());
}

TEST(Location, CasesCoverEveryInfluence) {
  const std::vector<LocationCase> cases = location_cases();
  for (const char* factor : {"contrast", "blur", "noise", "orientation", "phase", "shading", "background",
                             "before black", "transfer", "camera"}) {
    EXPECT_GT(std::ranges::count(cases, factor, &LocationCase::factor), 1) << factor;
  }
  for (const LocationCase& one : cases) {
    EXPECT_EQ(one.null_channel, one.factor != "before black" && one.level != "black") << one.factor << ' ' << one.level;
  }
}

}  // namespace
}  // namespace cylpose::bench
