#include <gtest/gtest.h>

#include <array>
#include <cylpose/pose_filter.hpp>
#include <cylpose/search_region.hpp>

#include "pose_filter_fixture.hpp"

namespace cylpose {
namespace {

using testing::kFrame;
using testing::kNotSeen;
using testing::Measuring;
using testing::MovingCylinder;
using testing::PoseFilterTest;
using testing::wrong;

TEST_F(PoseFilterTest, TheSearchRegionHoldsTheNextOutlines) {
  camera.distortion_model = DistortionModel::kPlumbBob;
  camera.distortion = {-0.2, 0.03, 0.001, -0.001, 0};
  double area = 0;
  int count = 0;
  for (unsigned seed = 1; seed <= 10; ++seed) {
    MovingCylinder::Motion motion{.velocity_drift = 0.15, .rate_drift = 0.3};
    MovingCylinder cylinder(motion, seed);
    Measuring measure(seed);
    PoseFilter filter = made();
    now = 0;
    follow(filter, cylinder, measure, 0.5);
    for (int frame = 0; frame < 60; ++frame) {
      follow(filter, cylinder, measure, kFrame);
      MovingCylinder future = cylinder;
      for (int lag = 0; lag <= 6; ++lag) {
        const Roi region = filter.search_region(now + lag * kFrame);
        const Roi outline = outline_box(camera, part, future.pose());
        ASSERT_FALSE(outline.empty());
        EXPECT_EQ(united(region, outline), region) << seed << " " << frame << " " << lag;
        EXPECT_EQ(united(region, whole), whole);
        if (lag == 1) {
          area +=
              static_cast<double>(region.width) * region.height / (static_cast<double>(outline.width) * outline.height);
          ++count;
        }
        future.advance(kFrame);
      }
    }
  }
  RecordProperty("area_ratio", std::to_string(area / count));
  EXPECT_LT(area / count, 2.5) << "region of the next frame, in areas of the outline's box";
}

TEST_F(PoseFilterTest, TheSearchRegionGrowsWithTimeUntilItIsTheWholeImage) {
  MovingCylinder cylinder({}, 1);
  Measuring measure(1);
  PoseFilter filter = made();
  EXPECT_EQ(filter.search_region(0), whole);
  follow(filter, cylinder, measure, 1);
  Roi last = filter.search_region(now);
  EXPECT_NE(last, whole);
  for (int i = 1; i < 28; ++i) {
    const Roi region = filter.search_region(now + i * kFrame);
    EXPECT_GE(region.width * region.height, last.width * last.height) << i;
    last = region;
  }
  EXPECT_EQ(filter.search_region(now + 1.51), whole);
  EXPECT_EQ(filter.search_region(now + 1e300), whole);
  // Contradicted: the track may be wrong.
  update(filter, now += kFrame, wrong(measure, 3));
  EXPECT_EQ(filter.search_region(now), whole);
  follow(filter, cylinder, measure, kFrame);
  EXPECT_NE(filter.search_region(now), whole);
  filter.reset();
  EXPECT_EQ(filter.search_region(0), whole);
}

TEST_F(PoseFilterTest, TheSearchRegionHoldsAllPartsAndIsWholeWhileOneIsMissing) {
  PoseFilter filter(camera, {part, part}, {});
  Measuring measure(1);
  const CylinderPose left{{-0.5, 0, 2}, -Eigen::Vector3d::UnitY()};
  const CylinderPose right{{0.4, 0.1, 2}, -Eigen::Vector3d::UnitY()};
  for (int i = 0; i < 5; ++i) {
    EXPECT_EQ(filter.search_region(now), whole);
    (void)filter.update(now += kFrame, std::array{measure(left), kNotSeen});
  }
  for (int i = 0; i < 3; ++i) {
    EXPECT_EQ(filter.search_region(now), whole);
    (void)filter.update(now += kFrame, std::array{measure(left), measure(right)});
  }
  const Roi region = filter.search_region(now);
  EXPECT_NE(region, whole);
  for (const CylinderPose& pose : {left, right}) {
    EXPECT_EQ(united(region, outline_box(camera, part, pose)), region);
  }
}

TEST_F(PoseFilterTest, TheSearchRegionStaysInsideTheImage) {
  for (const double x : {-0.8, 0.8}) {
    PoseFilter filter = made();
    Measuring measure(1);
    const CylinderPose pose{{x, 0.3, 1.5}, -Eigen::Vector3d::UnitY()};  // half of it seen
    now = 0;
    for (int i = 0; i < 5; ++i) update(filter, now += kFrame, measure(pose));
    const Roi region = filter.search_region(now);
    EXPECT_NE(region, whole);
    EXPECT_EQ(united(region, whole), whole);
    EXPECT_EQ(united(region, outline_box(camera, part, pose)), region);
  }
  // Out of the view: it may come back anywhere.
  PoseFilter filter = made();
  Measuring measure(1);
  for (int i = 0; i < 5; ++i) update(filter, now += kFrame, measure({{3, 0, 1.5}, -Eigen::Vector3d::UnitY()}));
  EXPECT_EQ(filter.search_region(now), whole);
}

}  // namespace
}  // namespace cylpose
