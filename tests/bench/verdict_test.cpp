#include "verdict.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace cylpose::bench {
namespace {

PoseError off_by(double position_m, double axis_deg) {
  PoseError error;
  error.position_m = position_m;
  error.axis_angle_deg = axis_deg;
  return error;
}

TEST(Verdict, InaccurateIsNotWrong) {
  EXPECT_FALSE(is_wrong(off_by(0.024, 9), 1, std::nullopt));
  EXPECT_FALSE(is_wrong(off_by(0.099, 9), 5, std::nullopt)) << "2 % of the distance";
  EXPECT_FALSE(is_wrong(off_by(0.001, 0.1), 1, 1000)) << "far beyond the bound, but small";
}

TEST(Verdict, WrongIsBeyondTheLimitsAndTheBound) {
  EXPECT_TRUE(is_wrong(off_by(0.026, 0), 1, std::nullopt));
  EXPECT_TRUE(is_wrong(off_by(0.101, 0), 5, std::nullopt));
  EXPECT_TRUE(is_wrong(off_by(0, 10.1), 1, std::nullopt));
  EXPECT_TRUE(is_wrong(off_by(0.026, 0), 1, 6.1));
  EXPECT_FALSE(is_wrong(off_by(0.026, 0), 1, 5.9)) << "the picture excuses it";
}

TEST(Verdict, NanIsWrong) {
  const double nan = std::nan("");
  EXPECT_TRUE(is_wrong(off_by(nan, 0), 1, std::nullopt));
  EXPECT_TRUE(is_wrong(off_by(0, nan), 1, nan));
  EXPECT_TRUE(is_wrong(off_by(0.3, 0), 1, nan));
}

TEST(Verdict, MahalanobisCountsSigmas) {
  Matrix5d bound = Matrix5d::Identity();
  bound(2, 2) = 4;
  EXPECT_NEAR(mahalanobis((Vector5d() << 0, 0, 6, 0, 0).finished(), bound), 3, 1e-12);
  EXPECT_NEAR(mahalanobis((Vector5d() << 3, 0, 0, 4, 0).finished(), bound), 5, 1e-12);
}

}  // namespace
}  // namespace cylpose::bench
