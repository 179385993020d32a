#include <gtest/gtest.h>

#include <cmath>
#include <cylpose/line.hpp>
#include <limits>
#include <numbers>
#include <numeric>
#include <random>

namespace cylpose {
namespace {

struct Points {
  std::vector<EdgePoint> points;

  // Adds points along a line at `angle`, through `middle`, and returns their indices.
  Chain add(double angle, const Eigen::Vector2d& middle, int count, double noise, std::mt19937& random) {
    const Eigen::Vector2d along(std::cos(angle), std::sin(angle));
    const Eigen::Vector2d inward(-along.y(), along.x());
    std::normal_distribution<double> error(0, 1);
    Chain chain;
    for (int i = 0; i < count; ++i) {
      chain.push_back(static_cast<int>(points.size()));
      points.push_back({middle + (i - (count - 1) / 2.0) * along + noise * error(random) * inward, inward});
    }
    return chain;
  }
};

double angle_between(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  return std::abs(std::atan2(a.x() * b.y() - a.y() * b.x(), a.dot(b)));
}

TEST(FitLine, AllDirectionsAlike) {
  std::mt19937 random(1);
  for (int degrees = 0; degrees < 360; degrees += 5) {
    const double angle = degrees * std::numbers::pi / 180;
    Points p;
    const Eigen::Vector2d middle(300, 200);
    const Chain chain = p.add(angle, middle, 200, 0.3, random);
    const FittedLine line = fit_line(p.points, chain);
    const Eigen::Vector2d inward(-std::sin(angle), std::cos(angle));
    EXPECT_LT(angle_between(line.line.normal, inward), 0.002) << degrees;  // inward, not outward
    EXPECT_LT(std::abs(signed_distance(line.line, middle)), 0.1) << degrees;
    EXPECT_NEAR(line.rms_px, 0.3, 0.06) << degrees;
    EXPECT_NEAR((line.to - line.from).norm(), 198, 1.5) << degrees;  // an end may be left out as an outlier
  }
}

TEST(FitLine, EndsFollowTheDirection) {
  std::mt19937 random(2);
  Points p;
  const Chain chain = p.add(0.7, {0, 0}, 50, 0, random);
  const FittedLine line = fit_line(p.points, chain);
  const Eigen::Vector2d direction(line.line.normal.y(), -line.line.normal.x());
  EXPECT_GT(direction.dot(line.to - line.from), 0);
}

TEST(FitLine, LeavesOutliersOut) {
  std::mt19937 random(3);
  Points p;
  Chain chain = p.add(0, {100, 50}, 100, 0.1, random);
  for (int i = 0; i < 4; ++i) {
    chain.push_back(static_cast<int>(p.points.size()));
    p.points.push_back({{151.0 + i, 51.5 + i}, Eigen::Vector2d::UnitY()});
  }
  EXPECT_LT(std::abs(signed_distance(fit_line(p.points, chain).line, {100, 50})), 0.05);
}

TEST(FindLines, MergesAcrossTheGapOfAnOccluder) {
  std::mt19937 random(4);
  Points p;
  const std::vector<Chain> segments = {
      p.add(0.3, {100, 100}, 40, 0.1, random),
      p.add(0.3, {100 + 120 * std::cos(0.3), 100 + 120 * std::sin(0.3)}, 60, 0.1, random)};
  const auto lines = find_lines(p.points, segments, {});
  ASSERT_EQ(lines.size(), 1U);
  EXPECT_GE(lines[0].points.size(), 97U);  // of 100; some are beyond three sigma
  EXPECT_GT((lines[0].to - lines[0].from).norm(), 160);
}

TEST(FindLines, KeepsWhatIsNotOneLine) {
  std::mt19937 random(5);
  Points p;
  std::vector<Chain> segments = {p.add(0.3, {100, 100}, 60, 0.1, random),
                                 p.add(0.3, {100, 106}, 50, 0.1, random),   // parallel, 6 px beside
                                 p.add(0.9, {180, 125}, 40, 0.1, random)};  // another direction
  // The same place, but the part on the other side: the two sides of a thin gap.
  segments.push_back(p.add(0.3 + std::numbers::pi, {100, 100}, 30, 0.1, random));
  EXPECT_EQ(find_lines(p.points, segments, {}).size(), 4U);
}

TEST(FindLines, ArcsAreNoLines) {
  Points p;
  Chain arc;
  for (int i = 0; i < 60; ++i) {
    arc.push_back(i);
    const double angle = 0.025 * i;
    const Eigen::Vector2d out(std::cos(angle), std::sin(angle));
    p.points.push_back({40 * out, -out});
  }
  EXPECT_TRUE(find_lines(p.points, std::vector<Chain>{arc}, {}).empty());
}

TEST(FindLines, OrderedBySupport) {
  std::mt19937 random(6);
  Points p;
  const std::vector<Chain> segments = {p.add(0, {0, 0}, 20, 0.1, random), p.add(1, {200, 0}, 90, 0.1, random),
                                       p.add(2, {0, 300}, 50, 0.1, random)};
  const auto lines = find_lines(p.points, segments, {});
  ASSERT_EQ(lines.size(), 3U);
  EXPECT_GE(lines[0].points.size(), lines[1].points.size());
  EXPECT_GE(lines[1].points.size(), lines[2].points.size());
}

TEST(LineOptions, RefusesNonsense) {
  LineOptions options;
  std::string why;
  EXPECT_TRUE(options.is_valid(&why));
  options.merge_angle_rad = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(options.is_valid(&why));
  EXPECT_NE(why.find("merge_angle_rad"), std::string::npos);
}

}  // namespace
}  // namespace cylpose
