// From edge pixels to the two candidate lines: thesis algorithms 5.1, 5.2 and 5.4.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cylpose/thesis.hpp>
#include <numbers>
#include <random>
#include <string_view>

namespace cylpose {
namespace {

using testing::ElementsAre;
using testing::SizeIs;
using Points = std::vector<Eigen::Vector2d>;

constexpr double kPi = std::numbers::pi;

Mask mask_of(const std::vector<std::string_view>& rows, int x = 0, int y = 0) {
  Mask mask{{x, y, static_cast<int>(rows.front().size()), static_cast<int>(rows.size())}, {}};
  for (const std::string_view row : rows) {
    for (const char c : row) mask.pixels.push_back(c == '#' ? 255 : 0);
  }
  return mask;
}

TEST(ThesisEdges, FollowsNeighboursInOrderInFrameCoordinates) {
  const auto edges = thesis_edges(mask_of({"......",  //
                                           ".##...",  //
                                           "...##.",  //
                                           "......"},
                                          100, 50),
                                  1);
  ASSERT_THAT(edges, SizeIs(1));
  EXPECT_THAT(edges[0], ElementsAre(Eigen::Vector2d(101, 51), Eigen::Vector2d(102, 51), Eigen::Vector2d(103, 52),
                                    Eigen::Vector2d(104, 52)));
}

TEST(ThesisEdges, TakesCornersAlong) {
  const auto edges = thesis_edges(mask_of({"##.",  //
                                           ".##",  //
                                           "..#"}),
                                  1);
  ASSERT_THAT(edges, SizeIs(1));
  EXPECT_THAT(edges[0], SizeIs(5));
}

TEST(ThesisEdges, ClosedContourIsOneEdgeWithEveryPixelOnce) {
  const auto edges = thesis_edges(mask_of({"####",  //
                                           "#..#",  //
                                           "####"}),
                                  1);
  ASSERT_THAT(edges, SizeIs(1));
  EXPECT_THAT(edges[0], SizeIs(10));
}

TEST(ThesisEdges, ScanStartsAgainBesideAFinishedEdgeAndReachesTheLastRowAndColumn) {
  const auto edges = thesis_edges(mask_of({"#....",  //
                                           "#...#",  //
                                           "#...#"}),
                                  1);
  ASSERT_THAT(edges, SizeIs(2));
  EXPECT_EQ(edges[0].back(), Eigen::Vector2d(0, 2));
  EXPECT_EQ(edges[1].back(), Eigen::Vector2d(4, 2));
}

TEST(ThesisEdges, SizeMustExceedTheMinimum) {
  const Mask three = mask_of({"###"});
  EXPECT_THAT(thesis_edges(three, 2), SizeIs(1));
  EXPECT_THAT(thesis_edges(three, 3), SizeIs(0));
}

Points straight(const Eigen::Vector2d& from, const Eigen::Vector2d& step, int count) {
  Points points;
  for (int i = 0; i < count; ++i) points.push_back(from + i * step);
  return points;
}

TEST(ThesisPieces, CutsAtTheCornerAndSharesIt) {
  Points edge = straight({0, 0}, {1, 0}, 41);
  const Points down = straight({40, 1}, {0, 1}, 50);
  edge.insert(edge.end(), down.begin(), down.end());
  EXPECT_THAT(thesis_pieces(edge, 30, 2), ElementsAre(EdgePiece{0, 41}, EdgePiece{40, 91}));
  EXPECT_THAT(thesis_pieces(edge, 45, 2), ElementsAre(EdgePiece{40, 91}));
}

TEST(ThesisPieces, DistanceDecides) {
  Points edge = straight({0, 0}, {1, 0}, 80);
  edge[40].y() = 1.9;
  EXPECT_THAT(thesis_pieces(edge, 30, 2), ElementsAre(EdgePiece{0, 80}));
  edge[40].y() = 2.0;
  EXPECT_THAT(thesis_pieces(edge, 30, 2), ElementsAre(EdgePiece{0, 41}, EdgePiece{40, 80}));
}

TEST(ThesisPieces, ClosedContourFallsIntoItsSides) {
  Points edge = straight({0, 0}, {1, 0}, 60);
  for (const Points& side :
       {straight({60, 0}, {0, 1}, 100), straight({60, 100}, {-1, 0}, 60), straight({0, 100}, {0, -1}, 99)}) {
    edge.insert(edge.end(), side.begin(), side.end());
  }
  EXPECT_THAT(thesis_pieces(edge, 30, 2), SizeIs(4));
  edge.push_back(edge.front());  // both ends in one place: the chord is a point
  EXPECT_THAT(thesis_pieces(edge, 30, 2), SizeIs(4));
}

TEST(ThesisPieces, NothingFromTooFewPixels) {
  EXPECT_THAT(thesis_pieces({}, 30, 2), SizeIs(0));
  EXPECT_THAT(thesis_pieces(straight({0, 0}, {1, 0}, 29), 30, 2), SizeIs(0));
  EXPECT_THAT(thesis_pieces(straight({0, 0}, {1, 0}, 30), 30, 2), SizeIs(1));
}

TEST(ThesisFit, ExactPointsGiveTheLineInEveryDirection) {
  for (int degrees = 0; degrees < 180; degrees += 3) {
    const double angle = degrees * kPi / 180;
    const Eigen::Vector2d direction(std::cos(angle), std::sin(angle));
    const ThesisLine line = thesis_fitted_line(straight({70, -30}, direction, 100));
    EXPECT_NEAR(line.normal().dot(direction), 0, 1e-12) << degrees;
    EXPECT_NEAR(line.delta_px, line.normal().dot(Eigen::Vector2d(70, -30)), 1e-9) << degrees;
    EXPECT_NEAR(line.squared_error_px2, 0, 1e-18) << degrees;
    EXPECT_THAT(line.points, SizeIs(100));
  }
}

// y on x would make of this nearly vertical side a line across it.
TEST(ThesisFit, SteepLineWithJitterStaysSteep) {
  Points points = straight({10, 0}, {0, 1}, 200);
  for (std::size_t i = 0; i < points.size(); i += 7) points[i].x() += 1;
  const ThesisLine line = thesis_fitted_line(points);
  EXPECT_NEAR(std::remainder(line.rho_rad, kPi), 0, 0.001);
  EXPECT_NEAR(std::abs(line.delta_px), 10.145, 0.05);
  EXPECT_NEAR(line.squared_error_px2, 0.124, 0.01);
}

TEST(ThesisFit, WholePixelsGiveTheTrueLine) {
  const double slope = 0.37;
  Points points;
  for (int x = 0; x < 300; ++x) points.emplace_back(x, std::round(slope * x + 5));
  const ThesisLine line = thesis_fitted_line(points);
  EXPECT_NEAR(line.normal().y() / line.normal().x(), -1 / slope, 0.003);
  EXPECT_NEAR(line.squared_error_px2, (1.0 / 12) / (1 + slope * slope), 0.01);
}

TEST(ThesisFit, ErrorLimitIsDoubledForUprightLinesOnly) {
  const ThesisOptions options;
  const auto with = [](double rho_degrees, double error) { return ThesisLine{rho_degrees * kPi / 180, 10, error, {}}; };
  EXPECT_TRUE(is_straight(with(30, 0.99), options));
  EXPECT_FALSE(is_straight(with(30, 1.0), options));
  for (const double upright : {-180.0, -90.0, 0.0, 0.9, 90.0, 179.5}) {
    EXPECT_TRUE(is_straight(with(upright, 1.99), options)) << upright;
    EXPECT_FALSE(is_straight(with(upright, 2.0), options)) << upright;
  }
  EXPECT_FALSE(is_straight(with(1.2, 1.5), options));
  EXPECT_FALSE(is_straight(with(0, std::nan("")), options));
}

ThesisLine with_support(double rho, double delta, std::size_t support) {
  return {rho, delta, 0.5, Points(support, Eigen::Vector2d::Zero())};
}

TEST(ThesisCombined, ParametersAreWeightedBySupport) {
  const auto lines = thesis_combined({with_support(0.50, 10, 100), with_support(0.54, 12, 300)}, {});
  ASSERT_THAT(lines, SizeIs(1));
  EXPECT_NEAR(lines[0].rho_rad, 0.53, 1e-12);
  EXPECT_NEAR(lines[0].delta_px, 11.5, 1e-12);
  EXPECT_THAT(lines[0].points, SizeIs(400));
}

TEST(ThesisCombined, KnowsALineByItsOppositeNormal) {
  const auto lines = thesis_combined({with_support(kPi - 0.01, 10, 100), with_support(0.01, -11, 100)}, {});
  ASSERT_THAT(lines, SizeIs(1));
  EXPECT_NEAR(std::abs(std::cos(lines[0].rho_rad)), 1, 1e-6);
  EXPECT_NEAR(lines[0].delta_px * std::cos(lines[0].rho_rad), -10.5, 1e-3);
}

TEST(ThesisCombined, KeepsDifferentLinesSortedBySupport) {
  const ThesisOptions options;
  const auto lines =
      thesis_combined({with_support(0.5, 10, 50), with_support(0.5, 10 + 1.01 * options.equal_distance_px, 70),
                       with_support(0.5 + 1.01 * options.equal_angle_rad, 10, 60), with_support(0.5, -10, 80)},
                      options);
  ASSERT_THAT(lines, SizeIs(4));
  EXPECT_THAT(lines[0].points, SizeIs(80));
  EXPECT_THAT(lines[3].points, SizeIs(50));
}

// A bar of 401 x 41 pixels at an angle: its orientation is the direction the sides must have.
RegionStatistics bar(double angle_rad) {
  RegionStatistics region;
  for (int s = -200; s <= 200; ++s) {
    for (int t = -20; t <= 20; ++t) {
      region.add(static_cast<int>(std::lround(500 + s * std::cos(angle_rad) - t * std::sin(angle_rad))),
                 static_cast<int>(std::lround(500 + s * std::sin(angle_rad) + t * std::cos(angle_rad))));
    }
  }
  return region;
}

std::optional<std::array<ThesisLine, 2>> candidates(std::vector<ThesisLine> lines, double region_angle,
                                                    std::string* why = nullptr) {
  const ThesisOptions options;
  return thesis_candidates(thesis_combined(std::move(lines), options), bar(region_angle), options, why);
}

TEST(ThesisCandidates, LinesAcrossTheRegionAreLeftOut) {
  // Directions 60 (the region's), 60 + 34 and 60 + 36 degrees; the last has the most support.
  const double rho = 150 * kPi / 180;
  const auto sides = candidates({with_support(rho + 36 * kPi / 180, 0, 300), with_support(rho, 20, 200),
                                 with_support(rho + 34 * kPi / 180, -20, 100)},
                                60 * kPi / 180);
  ASSERT_TRUE(sides);
  EXPECT_THAT((*sides)[0].points, SizeIs(200));
  EXPECT_THAT((*sides)[1].points, SizeIs(100));
}

TEST(ThesisCandidates, OneLineIsNotEnough) {
  std::string why;
  EXPECT_FALSE(candidates({with_support(0, 20, 200), with_support(kPi / 2, 5, 100)}, kPi / 2, &why));
  EXPECT_THAT(why, testing::StartsWith("1 of 2 straight lines run along the region"));
}

TEST(ThesisCandidates, AngleDecidesBetweenRivalsOnly) {
  // The second line by support has a rival with less angle to the first...
  const auto close =
      candidates({with_support(0, 20, 300), with_support(0.2, -20, 200), with_support(0.02, -30, 180)}, kPi / 2);
  ASSERT_TRUE(close);
  EXPECT_THAT((*close)[1].points, SizeIs(180));
  // ...which does not count when it is much weaker.
  const auto clear =
      candidates({with_support(0, 20, 300), with_support(0.2, -20, 200), with_support(0.02, -30, 120)}, kPi / 2);
  ASSERT_TRUE(clear);
  EXPECT_THAT((*clear)[1].points, SizeIs(200));
}

TEST(ThesisOptions, RefuseWhatMakesNoSense) {
  std::string why;
  EXPECT_TRUE(ThesisOptions{}.is_valid(&why));
  ThesisOptions options;
  options.max_squared_error_px2 = std::nan("");
  EXPECT_FALSE(options.is_valid(&why));
  EXPECT_THAT(why, testing::HasSubstr("max_squared_error_px2 is nan"));
  options = {};
  options.min_edge_size = 1;
  EXPECT_FALSE(options.is_valid(&why));
  EXPECT_THAT(why, testing::HasSubstr("min_edge_size is 1; give a number within 2.."));
}

}  // namespace
}  // namespace cylpose
