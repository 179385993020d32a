#include "agreement.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <limits>
#include <string>
#include <utility>
#include <vector>

namespace cylpose::bench {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

constexpr Tolerance kExact;
constexpr Tolerance kLoose{0.01, 0.01, 0.001, 0.005};

// A hollow square of edges around a square mask.
EdgeField square(int shift = 0) {
  EdgeField field;
  field.searched = {0, 0, 60, 50};
  PartEdges& part = field.parts.emplace_back();
  part.mask.roi = field.searched;
  part.mask.pixels.assign(60 * 50, 0);
  for (int y = 10; y < 40; ++y) {
    for (int x = 10 + shift; x < 40 + shift; ++x) {
      part.region.add(x, y);
      part.mask.pixels[static_cast<std::size_t>(y * 60 + x)] = 255;
      if (x > 10 + shift && x < 39 + shift && y > 10 && y < 39) continue;
      part.edges.push_back(
          {static_cast<std::int16_t>(x), static_cast<std::int16_t>(y), 100, 0, 0, EdgeStrength::kStrong});
    }
  }
  part.region.box = {10 + shift, 10, 30, 30};
  return field;
}

std::vector<PoseEstimate> pose(const Eigen::Vector3d& center = {0, 0, 2}) {
  std::vector<PoseEstimate> poses(1);
  poses[0].status = PoseStatus::kOk;
  poses[0].pose = {center, Eigen::Vector3d::UnitX()};
  return poses;
}

TEST(Agreement, EqualFieldsAndPosesDoNotDiffer) {
  for (const Tolerance& tolerance : {kExact, kLoose}) {
    EXPECT_THAT(difference(square(), square(), tolerance), IsEmpty());
    EXPECT_THAT(difference(pose(), pose(), tolerance), IsEmpty());
  }
}

TEST(Agreement, EveryBitOfAFieldCountsWhereEqualityIsPromised) {
  const std::vector<std::pair<const char*, std::function<void(EdgeField&)>>> faults{
      {"region", [](EdgeField& field) { field.searched.width -= 1; }},
      {"number of parts", [](EdgeField& field) { field.parts.clear(); }},
      {"moment", [](EdgeField& field) { field.parts[0].region.m11 += 1; }},
      {"edge pixels", [](EdgeField& field) { field.parts[0].edges[7].offset_256 += 1; }},
      {"edge pixels", [](EdgeField& field) { field.parts[0].edges.pop_back(); }},
      {"another mask", [](EdgeField& field) { field.parts[0].mask.pixels[0] = 255; }},
      {"mask of another region", [](EdgeField& field) { field.parts[0].mask = {}; }},
  };
  for (const auto& [expected, damage] : faults) {
    EdgeField damaged = square();
    damage(damaged);
    EXPECT_THAT(difference(square(), damaged, kExact), HasSubstr(expected));
  }
}

TEST(Agreement, ToleranceForgivesAPixelButNotTwo) {
  EdgeField damaged = square();
  damaged.parts[0].mask.pixels[0] = 255;
  damaged.parts[0].edges[7].offset_256 += 1;
  EXPECT_THAT(difference(square(), damaged, kLoose), IsEmpty());
  EXPECT_THAT(difference(square(), square(1), kLoose), HasSubstr("mask's pixels differ"));

  // Edges alone, both ways.
  EdgeField moved = square(2);
  moved.parts[0].mask = square().parts[0].mask;
  EXPECT_THAT(difference(square(), moved, kLoose), HasSubstr("missing"));
  EdgeField more = square();
  for (std::int16_t x = 15; x < 35; ++x) more.parts[0].edges.push_back({x, 25, 100, 0, 0, EdgeStrength::kStrong});
  EXPECT_THAT(difference(square(), more, kLoose), HasSubstr("not expected"));
  EdgeField none = square();
  none.parts[0].edges.clear();
  EXPECT_THAT(difference(square(), none, kLoose), HasSubstr("missing"));
}

TEST(Agreement, PosesDifferByStatusPlaceAndDirection) {
  std::vector<PoseEstimate> none = pose();
  none[0].status = PoseStatus::kNone;
  std::vector<PoseEstimate> turned = pose();
  turned[0].pose.axis_in_cam = Eigen::Vector3d(1, 0.01, 0).normalized();
  for (const Tolerance& tolerance : {kExact, kLoose}) {
    EXPECT_THAT(difference(pose(), none, tolerance), HasSubstr("status"));
    EXPECT_THAT(difference(pose(), {}, tolerance), HasSubstr("number of poses"));
    EXPECT_THAT(difference(pose(), turned, tolerance), Not(IsEmpty()));
    EXPECT_THAT(difference(pose(), pose({0, 0, 2.01}), tolerance), Not(IsEmpty()));
    EXPECT_THAT(difference(pose(), pose({0, 0, std::numeric_limits<double>::quiet_NaN()}), tolerance), Not(IsEmpty()));
  }
  EXPECT_THAT(difference(pose(), pose({0, 0, 2.001}), kLoose), IsEmpty());
  EXPECT_THAT(difference(pose(), pose({0, 0, 2.001}), kExact), Not(IsEmpty()));
  std::vector<PoseEstimate> mirrored = pose();
  mirrored[0].pose.axis_in_cam *= -1;
  EXPECT_THAT(difference(pose(), mirrored, kLoose), IsEmpty());
}

TEST(Agreement, OnlyOpencvMayDiffer) {
  EXPECT_FALSE(tolerance_of("opencv").exact());
  for (const char* backend : {"serial", "opencl", "cluster"}) EXPECT_TRUE(tolerance_of(backend).exact());
}

}  // namespace
}  // namespace cylpose::bench
