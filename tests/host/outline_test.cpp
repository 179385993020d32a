#include <gtest/gtest.h>

#include <algorithm>
#include <cylpose/curved_border.hpp>
#include <cylpose/outline.hpp>

#include "ideal_edges.hpp"

namespace cylpose {
namespace {

using testing::random_pose;
using testing::test_camera;
using testing::test_part;

class OutlineTest : public ::testing::Test {
 protected:
  std::vector<EdgePoint> exact_points(const CylinderPose& pose) const {
    return edge_points(camera, testing::ideal_edges(camera, part, pose).edges);
  }

  std::vector<EdgePoint> points_on_border(const CylinderPose& pose) const {
    return edge_points(camera, testing::ideal_edges(camera, part, pose, {.on_border = true}).edges);
  }

  CameraModel camera = test_camera();
  PartModel part = test_part();
};

TEST_F(OutlineTest, EdgesOfThePoseLieOnIt) {
  std::mt19937 random(1);
  for (int i = 0; i < 50; ++i) {
    const CylinderPose pose = random_pose(random, part);
    const auto outline = Outline::of(camera, part, pose);
    ASSERT_TRUE(outline);
    int unmatched = 0;
    int bent = 0;
    std::array<int, kOutlinePieces> per_piece{};
    const auto points = exact_points(pose);
    for (const EdgePoint& point : points) {
      const auto match = outline->match(point, 1.0);
      if (!match) {
        ++unmatched;
        continue;
      }
      // A pixel beside a tight arc does not have its foot point where the edge was sampled: few, and little.
      EXPECT_LT(std::abs(match->distance_px), 0.4);
      if (std::abs(match->distance_px) > 0.02) ++bent;
      ++per_piece[static_cast<std::size_t>(match->piece)];
    }
    EXPECT_LE(unmatched, static_cast<int>(points.size()) / 50) << i;  // a few in the corners
    EXPECT_LE(bent, static_cast<int>(points.size()) / 10) << i;
    for (const int count : per_piece) EXPECT_GT(count, 3) << i;
  }
}

TEST_F(OutlineTest, DistanceIsSignedAndInPixels) {
  std::mt19937 random(2);
  const CylinderPose pose = random_pose(random, part);
  const auto outline = Outline::of(camera, part, pose);
  ASSERT_TRUE(outline);
  int checked = 0;
  for (EdgePoint point : exact_points(pose)) {
    const auto on = outline->match(point, 0.5);
    if (!on) continue;
    for (const double move : {-1.5, 0.7}) {
      EdgePoint moved = point;
      moved.position_px += move * on->inward;
      const auto match = outline->match(moved, 3);
      if (!match || match->piece != on->piece) continue;
      EXPECT_NEAR(match->distance_px, on->distance_px + move, 0.1);
      ++checked;
    }
  }
  EXPECT_GT(checked, 50);
}

TEST_F(OutlineTest, BaseDistanceIsThatOfTheNearestPlace) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> moves(-1.2, 1.2);
  int checked = 0;
  int off = 0;
  for (int i = 0; i < 60; ++i) {
    const CylinderPose pose = random_pose(random, part);
    const auto outline = Outline::of(camera, part, pose);
    ASSERT_TRUE(outline);
    const std::vector<Eigen::Vector2d> rays = silhouette(pose, part.radius_m, part.height_m, 4000);
    std::vector<Eigen::Vector2d> dense;
    for (const Eigen::Vector2d& ray : rays) dense.push_back(ideal_pixel(camera, {ray.x(), ray.y(), 1}));
    // By the circle through three places. On an arc; its ends are corners.
    const auto curvature_at = [&](std::size_t k) {
      const Eigen::Vector2d before = dense[k] - dense[(k + dense.size() - 1) % dense.size()];
      const Eigen::Vector2d after = dense[(k + 1) % dense.size()] - dense[k];
      const double twice_area = before.x() * after.y() - before.y() * after.x();
      return 2 * std::abs(twice_area) / (before.norm() * after.norm() * (before + after).norm());
    };
    for (EdgePoint point : points_on_border(pose)) {
      point.position_px += moves(random) * point.inward;
      const auto match = outline->match(point, 1.5);
      if (!match || (match->piece != kBase0 && match->piece != kBase1)) continue;
      const auto nearest = static_cast<std::size_t>(
          std::ranges::distance(dense.begin(), std::ranges::min_element(dense, {}, [&](const Eigen::Vector2d& place) {
                                  return (place - point.position_px).squaredNorm();
                                })));
      const Eigen::Vector2d offset = point.position_px - dense[nearest];
      const double distance_px = match->inward.dot(offset) < 0 ? -offset.norm() : offset.norm();
      if (std::abs(match->distance_px + inward_shift_px(curvature_at(nearest)) - distance_px) > 0.002) ++off;
      ++checked;
    }
  }
  EXPECT_GT(checked, 1000);
  // Where an arc ends the nearest place may be one whose normal does not agree.
  EXPECT_LE(off, checked / 50);
}

TEST_F(OutlineTest, NormalsMustAgree) {
  const CylinderPose pose{{0, 0, 2}, Eigen::Vector3d(0.3, -1, 0.2).normalized()};
  const auto outline = Outline::of(camera, part, pose);
  ASSERT_TRUE(outline);
  for (EdgePoint point : exact_points(pose)) {
    point.inward = -point.inward;
    const auto match = outline->match(point, 1.0);
    EXPECT_FALSE(match);
  }
}

TEST_F(OutlineTest, FarPointsDoNotMatch) {
  const CylinderPose pose{{0, 0, 2}, -Eigen::Vector3d::UnitY()};
  const auto outline = Outline::of(camera, part, pose);
  ASSERT_TRUE(outline);
  EXPECT_FALSE(outline->match({{100, 100}, Eigen::Vector2d::UnitX()}, 6));
  // On the side line, but beyond the end of the part.
  const Eigen::Vector2d beyond = outline->sides()[0].normal * outline->sides()[0].distance + Eigen::Vector2d(0, 600);
  EXPECT_FALSE(outline->match({beyond, outline->sides()[0].normal}, 6));
}

TEST_F(OutlineTest, AreaAndInsideAgreeWithRays) {
  std::mt19937 random(3);
  for (int i = 0; i < 20; ++i) {
    const CylinderPose pose = random_pose(random, part);
    const auto outline = Outline::of(camera, part, pose);
    ASSERT_TRUE(outline);
    const auto field = testing::ideal_edges(camera, part, pose);
    EXPECT_NEAR(outline->area_px() / static_cast<double>(field.region.m00), 1, 0.04) << i;
  }
}

TEST_F(OutlineTest, WithinKeepsItsMargin) {
  const CylinderPose pose{{0, 0, 2}, -Eigen::Vector3d::UnitY()};
  const auto outline = Outline::of(camera, part, pose);
  ASSERT_TRUE(outline);
  const double half_width = 1215 * 0.05 / std::sqrt(4 - 0.05 * 0.05);
  EXPECT_TRUE(outline->within({639.5 + half_width - 3.1, 359.5}, 3));
  EXPECT_FALSE(outline->within({639.5 + half_width - 2.9, 359.5}, 3));
  EXPECT_TRUE(outline->within({639.5 + half_width + 2.9, 359.5}, -3));
}

TEST_F(OutlineTest, BeyondIsOutsideByMoreThanTheMargin) {
  std::mt19937 random(6);
  for (int i = 0; i < 30; ++i) {
    const CylinderPose pose = random_pose(random, part);
    const auto outline = Outline::of(camera, part, pose);
    ASSERT_TRUE(outline);
    int wrong = 0;
    const auto points = points_on_border(pose);
    for (const EdgePoint& point : points) {
      EXPECT_FALSE(outline->beyond(point.position_px, 1)) << i;
      EXPECT_FALSE(outline->beyond(point.position_px + 8 * point.inward, 1)) << i;
      EXPECT_FALSE(outline->beyond(point.position_px - 2 * point.inward, 4)) << i;
      if (!outline->beyond(point.position_px - 6 * point.inward, 4)) ++wrong;
    }
    EXPECT_LE(wrong, static_cast<int>(points.size()) / 20) << i;  // to first order, beside tight bends
  }
}

TEST_F(OutlineTest, BulgeIsHowFarTheArcReaches) {
  // Across the line of sight only perspective makes the rim more than a line; along it half of the base shows.
  const auto bulge_at = [&](double tilt) {
    const CylinderPose pose{{0, 0, 2}, Eigen::Vector3d(std::sin(tilt), 0, std::cos(tilt))};
    const auto outline = Outline::of(camera, part, pose);
    return std::max(outline->bulge_px(0), outline->bulge_px(1));
  };
  const double radius_px = 1215 * 0.05 / 2;
  EXPECT_LT(bulge_at(1.57), 0.15 * radius_px);
  EXPECT_NEAR(bulge_at(0.8), std::cos(0.8) * radius_px, 0.25 * radius_px);
  EXPECT_GT(bulge_at(0.8), 0.5 * radius_px);
}

TEST_F(OutlineTest, StationsCoverEveryPieceInsideTheOutlinesBox) {
  std::mt19937 random(4);
  const CylinderPose pose = random_pose(random, part);
  const auto outline = Outline::of(camera, part, pose);
  ASSERT_TRUE(outline);
  std::array<int, kOutlinePieces> per_piece{};
  for (const auto& station : outline->stations()) ++per_piece[station.piece];
  for (const int count : per_piece) EXPECT_GE(count, 6);
}

TEST_F(OutlineTest, NoneFromInsideOrBehind) {
  EXPECT_FALSE(Outline::of(camera, part, {{0, 0, 2}, Eigen::Vector3d::UnitZ()}));
  EXPECT_FALSE(Outline::of(camera, part, {{0, 0, 0.1}, Eigen::Vector3d(0, 0.3, 1).normalized()}));
}

}  // namespace
}  // namespace cylpose
