#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cylpose/contour.hpp>
#include <numeric>
#include <set>
#include <string>

#include "ideal_edges.hpp"

namespace cylpose {
namespace {

using ::testing::ElementsAre;

// '#' strong, '+' weak, anything else no edge.
std::vector<EdgePixel> pixels_of(const std::vector<std::string>& rows) {
  std::vector<EdgePixel> pixels;
  for (std::size_t y = 0; y < rows.size(); ++y) {
    for (std::size_t x = 0; x < rows[y].size(); ++x) {
      const char c = rows[y][x];
      if (c != '#' && c != '+') continue;
      pixels.push_back({static_cast<std::int16_t>(x), static_cast<std::int16_t>(y), 0, 100, 0,
                        c == '#' ? EdgeStrength::kStrong : EdgeStrength::kWeak});
    }
  }
  return pixels;
}

std::set<int> members(const std::vector<Chain>& chains) {
  std::set<int> all;
  for (const Chain& chain : chains) all.insert(chain.begin(), chain.end());
  return all;
}

TEST(Hysteresis, KeepsWeakEdgesThatContinueStrongOnes) {
  const auto kept = with_hysteresis(pixels_of({
      "#++......++",  //
      "...+.......",  //
      "....+...+..",  //
  }));
  ASSERT_EQ(kept.size(), 5U);
  EXPECT_EQ(kept[0].strength, EdgeStrength::kStrong);
  EXPECT_EQ(kept[4].x, 4);
  EXPECT_EQ(kept[4].y, 2);
}

TEST(Hysteresis, NothingStrongNothingKept) {
  EXPECT_TRUE(with_hysteresis(pixels_of({"++++", "++++"})).empty());
  EXPECT_TRUE(with_hysteresis({}).empty());
}

TEST(Hysteresis, AGapOfOnePixelSeparates) {
  EXPECT_EQ(with_hysteresis(pixels_of({"##.++"})).size(), 2U);
  EXPECT_EQ(with_hysteresis(pixels_of({"##...", ".....", "..+.."})).size(), 2U);
}

TEST(Chains, AStraightLineIsOneOrderedChain) {
  const auto chains = extract_chains(pixels_of({"#####"}), 2);
  ASSERT_EQ(chains.size(), 1U);
  EXPECT_THAT(chains[0], ::testing::AnyOf(ElementsAre(0, 1, 2, 3, 4), ElementsAre(4, 3, 2, 1, 0)));
}

TEST(Chains, AChainStartedInItsMiddleGoesBothWays) {
  // The row scan meets the top of the V first.
  const auto pixels = pixels_of({
      "..#..",  //
      ".#.#.",  //
      "#...#",  //
  });
  const auto chains = extract_chains(pixels, 2);
  ASSERT_EQ(chains.size(), 1U);
  EXPECT_THAT(chains[0], ::testing::AnyOf(ElementsAre(3, 1, 0, 2, 4), ElementsAre(4, 2, 0, 1, 3)));
}

TEST(Chains, ACrossingGoesStraightOn) {
  const auto pixels = pixels_of({
      "....#....",  //
      "....#....",  //
      "....#....",  //
      "....#....",  //
      "#########",  //
      "....#....",  //
      "....#....",  //
      "....#....",  //
  });
  const auto chains = extract_chains(pixels, 4);
  ASSERT_FALSE(chains.empty());
  EXPECT_EQ(chains[0].size(), 8U);  // the whole vertical, crossing included
  for (const int i : chains[0]) EXPECT_EQ(pixels[static_cast<std::size_t>(i)].x, 4);
}

TEST(Chains, EveryPixelIsInOneChainAtMostAndShortOnesAreLeftOut) {
  std::mt19937 random(1);
  std::vector<std::string> rows(40, std::string(70, '.'));
  for (auto& row : rows) {
    for (auto& c : row) c = random() % 4 == 0 ? '#' : '.';
  }
  const auto pixels = pixels_of(rows);
  const auto all = extract_chains(pixels, 1);
  const std::size_t total = std::accumulate(all.begin(), all.end(), std::size_t{0},
                                            [](std::size_t n, const Chain& c) { return n + c.size(); });
  EXPECT_EQ(total, pixels.size());
  EXPECT_EQ(members(all).size(), pixels.size());
  for (const Chain& chain : all) {
    for (std::size_t i = 1; i < chain.size(); ++i) {
      const EdgePixel& a = pixels[static_cast<std::size_t>(chain[i - 1])];
      const EdgePixel& b = pixels[static_cast<std::size_t>(chain[i])];
      EXPECT_LE(std::max(std::abs(a.x - b.x), std::abs(a.y - b.y)), 1);
    }
  }
  for (const Chain& chain : extract_chains(pixels, 5)) EXPECT_GE(chain.size(), 5U);
}

TEST(EdgePoints, LieAtTheOffsetAlongTheGradient) {
  const std::vector<EdgePixel> edges = {{10, 20, 300, 400, 128, EdgeStrength::kStrong}};
  const auto points = edge_points(testing::test_camera(), edges);
  ASSERT_EQ(points.size(), 1U);
  EXPECT_NEAR(points[0].position_px.x(), 10 + 0.5 * 0.6, 1e-12);
  EXPECT_NEAR(points[0].position_px.y(), 20 + 0.5 * 0.8, 1e-12);
  EXPECT_NEAR(points[0].inward.y(), 0.8, 1e-12);
}

TEST(EdgePoints, AreUndistorted) {
  CameraModel camera = testing::test_camera();
  camera.distortion_model = DistortionModel::kPlumbBob;
  camera.distortion = {-0.3, 0.1, 0, 0};
  const Eigen::Vector3d point_in_cam(0.4, 0.2, 1);
  const Eigen::Vector2d seen = project(camera, point_in_cam);
  const auto x = static_cast<std::int16_t>(std::lround(seen.x()));
  const auto offset = static_cast<std::int16_t>(std::lround(256 * (seen.x() - x)));
  const auto y = static_cast<std::int16_t>(std::lround(seen.y()));
  const std::vector<EdgePixel> edges = {{x, y, 1000, 0, offset, EdgeStrength::kStrong}};
  const Eigen::Vector2d ideal = ideal_pixel(camera, point_in_cam);
  EXPECT_GT((seen - ideal).norm(), 20);
  EXPECT_LT((edge_points(camera, edges)[0].position_px - ideal).norm(), 0.6);  // the row is rounded to a pixel
}

std::vector<EdgePoint> points_at(const std::vector<Eigen::Vector2d>& positions) {
  std::vector<EdgePoint> points;
  for (const Eigen::Vector2d& p : positions) points.push_back({p, Eigen::Vector2d::UnitY()});
  return points;
}

Chain all_of(const std::vector<EdgePoint>& points) {
  Chain chain(points.size());
  std::iota(chain.begin(), chain.end(), 0);
  return chain;
}

TEST(Split, CutsAtTheCorner) {
  std::vector<Eigen::Vector2d> positions;
  for (int i = 0; i <= 30; ++i) positions.emplace_back(i, 0);
  for (int i = 1; i <= 20; ++i) positions.emplace_back(30, i);
  const auto points = points_at(positions);
  const auto segments = split_where_bent(std::vector<Chain>{all_of(points)}, points, 1.0, 5);
  ASSERT_EQ(segments.size(), 2U);
  EXPECT_EQ(segments[0].front(), 0);
  EXPECT_EQ(segments[0].back(), 30);
  EXPECT_EQ(segments[1].front(), 30);
  EXPECT_EQ(segments[1].back(), 50);
}

TEST(Split, LeavesAStraightChainWholeAndDropsShortPieces) {
  std::vector<Eigen::Vector2d> positions;
  for (int i = 0; i <= 30; ++i) positions.emplace_back(i, 0.3 * (i % 2));
  const auto straight = points_at(positions);
  EXPECT_EQ(split_where_bent(std::vector<Chain>{all_of(straight)}, straight, 1.0, 5).size(), 1U);
  positions.emplace_back(30, 3);
  positions.emplace_back(30, 6);
  const auto hooked = points_at(positions);
  EXPECT_EQ(split_where_bent(std::vector<Chain>{all_of(hooked)}, hooked, 1.0, 5).size(), 1U);
}

TEST(Split, AClosedChainIsCutToo) {
  std::vector<Eigen::Vector2d> positions;
  for (int i = 0; i < 20; ++i) positions.emplace_back(i, 0);
  for (int i = 0; i < 20; ++i) positions.emplace_back(20, i);
  for (int i = 20; i > 0; --i) positions.emplace_back(i, 20);
  for (int i = 20; i >= 0; --i) positions.emplace_back(0, i);
  const auto points = points_at(positions);
  EXPECT_EQ(split_where_bent(std::vector<Chain>{all_of(points)}, points, 1.0, 5).size(), 4U);
}

}  // namespace
}  // namespace cylpose
