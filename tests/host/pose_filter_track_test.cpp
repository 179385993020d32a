#include <gtest/gtest.h>

#include <cmath>
#include <cylpose/pose_filter.hpp>

#include "pose_filter_fixture.hpp"

namespace cylpose {
namespace {

using testing::kFrame;
using testing::kNotSeen;
using testing::matched;
using testing::Measuring;
using testing::MovingCylinder;
using testing::normalised_error;
using testing::PoseFilterTest;
using testing::wrong;

TEST_F(PoseFilterTest, CoastsThroughASecondOfOcclusion) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    MovingCylinder::Motion motion{.velocity_drift = 0.05, .rate_drift = 0.1};
    MovingCylinder cylinder(motion, seed);
    Measuring measure(seed);
    PoseFilter filter = made(matched(0.05, 0.1));
    now = 0;
    PoseEstimate last = follow(filter, cylinder, measure, 2);
    ASSERT_EQ(last.status, PoseStatus::kOk);
    for (int i = 0; i < 30; ++i) {
      const PoseEstimate predicted = update(filter, now += kFrame, kNotSeen);
      ASSERT_EQ(predicted.status, PoseStatus::kPredicted) << i;
      EXPECT_EQ(predicted.reason, kNotSeen.reason);
      EXPECT_LT(normalised_error(predicted, cylinder.advance(kFrame)), 20.5) << seed << " " << i;
      for (int k = 0; k < 3; ++k) EXPECT_GT(predicted.covariance(k, k), last.covariance(k, k)) << i;
      EXPECT_GT(predicted.sigma_axis_rad(), last.sigma_axis_rad()) << i;
      EXPECT_GT(predicted.pose.axis_in_cam.dot(last.pose.axis_in_cam), 0.99);
      last = predicted;
    }
    // One measurement is not enough after so long, three are.
    for (const PoseStatus status : {PoseStatus::kPredicted, PoseStatus::kPredicted, PoseStatus::kOk}) {
      const PoseEstimate found = update(filter, now += kFrame, measure(cylinder.advance(kFrame)));
      EXPECT_EQ(found.status, status) << seed;
      EXPECT_LT(normalised_error(found, cylinder.pose()), 20.5) << seed;
      EXPECT_GT(found.pose.axis_in_cam.dot(last.pose.axis_in_cam), 0.9) << seed;
    }
  }
}

TEST_F(PoseFilterTest, IsLostAfterTheStatedTime) {
  MovingCylinder cylinder({}, 1);
  Measuring measure(1);
  FilterOptions options;
  options.max_coast_s = 0.49;
  PoseFilter filter = made(options);
  follow(filter, cylinder, measure, 1);
  const double last_seen = now;
  for (int i = 1; i <= 20; ++i) {
    const PoseEstimate coasting = update(filter, last_seen + i * kFrame, kNotSeen);
    EXPECT_EQ(coasting.status, i * kFrame < 0.49 ? PoseStatus::kPredicted : PoseStatus::kNone) << i;
    EXPECT_EQ(coasting.reason, kNotSeen.reason);
  }
}

TEST_F(PoseFilterTest, IsLostWhenUnsure) {
  for (const bool by_center : {true, false}) {
    MovingCylinder cylinder({}, 1);
    Measuring measure(1);
    FilterOptions options;
    (by_center ? options.max_center_sigma_m : options.max_axis_sigma_deg) = by_center ? 0.03 : 5;
    PoseFilter filter = made(options);
    now = 0;
    follow(filter, cylinder, measure, 1);
    PoseEstimate coasting = update(filter, now += kFrame, kNotSeen);
    EXPECT_EQ(coasting.status, PoseStatus::kPredicted);
    while (coasting.status == PoseStatus::kPredicted && now < 2) {
      EXPECT_LE(coasting.sigma_axis_rad() * 180 / M_PI, options.max_axis_sigma_deg);
      EXPECT_LE(std::sqrt(coasting.covariance(2, 2)), options.max_center_sigma_m);
      coasting = update(filter, now += kFrame, kNotSeen);
    }
    EXPECT_LT(now, 1.9) << "the time was no reason to be lost";
  }
}

class PoseFilterOutliers : public PoseFilterTest {
 protected:
  void SetUp() override { follow(filter, cylinder, measure, 1); }

  PoseEstimate next_wrong(int which) {
    cylinder.advance(kFrame);
    return update(filter, now += kFrame, wrong(measure, which));
  }
  PoseEstimate next_right() { return update(filter, now += kFrame, measure(cylinder.advance(kFrame))); }

  double error(const PoseEstimate& estimate) {
    return (estimate.pose.center_in_cam - cylinder.pose().center_in_cam).norm();
  }

  MovingCylinder cylinder{{}, 1};
  Measuring measure{1};
  PoseFilter filter = made();
  static constexpr double kOnTrack = 0.02;  // metres; the wrong ones are ten times as far
};

TEST_F(PoseFilterOutliers, OneWrongMeasurementMovesNothing) {
  for (int i = 0; i < 10; ++i) {
    const PoseEstimate rejected = next_wrong(i);
    EXPECT_EQ(rejected.status, PoseStatus::kPredicted);
    EXPECT_FALSE(rejected.reason.empty());
    EXPECT_EQ(rejected.support, 0);
    EXPECT_LT(error(rejected), kOnTrack);
    const PoseEstimate right = next_right();
    EXPECT_EQ(right.status, PoseStatus::kOk);
    EXPECT_EQ(right.support, 500);
    EXPECT_LT(error(right), kOnTrack);
  }
}

TEST_F(PoseFilterOutliers, ABurstOfScatteredOnesMovesNothing) {
  for (int i = 0; i < 20; ++i) {
    const PoseEstimate rejected = next_wrong(i);
    EXPECT_EQ(rejected.status, PoseStatus::kPredicted) << i;
    EXPECT_LT(error(rejected), 0.1) << i;
  }
  // Coasted over more than two frames: three that agree take the track up again.
  EXPECT_EQ(next_right().status, PoseStatus::kPredicted);
  EXPECT_EQ(next_right().status, PoseStatus::kPredicted);
  const PoseEstimate again = next_right();
  EXPECT_EQ(again.status, PoseStatus::kOk);
  EXPECT_LT(error(again), kOnTrack);
}

TEST_F(PoseFilterOutliers, AConsistentWrongPoseIsFollowedFromTheFifthFrameOnlyAndNoLongerThanItLasts) {
  for (int i = 0; i < 4; ++i) {
    const PoseEstimate rejected = next_wrong(7);
    EXPECT_EQ(rejected.status, PoseStatus::kPredicted);
    EXPECT_LT(error(rejected), kOnTrack);
  }
  const PoseEstimate switched = next_wrong(7);
  EXPECT_EQ(switched.status, PoseStatus::kOk);
  EXPECT_GT(error(switched), 0.2);
  for (int i = 0; i < 20; ++i) EXPECT_EQ(next_wrong(7).status, PoseStatus::kOk);

  for (int i = 0; i < 4; ++i) EXPECT_EQ(next_right().status, PoseStatus::kPredicted);
  const PoseEstimate back = next_right();
  EXPECT_EQ(back.status, PoseStatus::kOk);
  EXPECT_LT(error(back), kOnTrack);
}

TEST_F(PoseFilterOutliers, FourWrongOnesLeaveTheTrackWhereItWas) {
  for (int i = 0; i < 4; ++i) next_wrong(7);
  next_right();
  next_right();
  const PoseEstimate again = next_right();
  EXPECT_EQ(again.status, PoseStatus::kOk);
  EXPECT_LT(error(again), kOnTrack);
}

TEST_F(PoseFilterOutliers, OneWrongMeasurementAfterAnOcclusionMovesNothing) {
  for (int i = 0; i < 20; ++i) {
    cylinder.advance(kFrame);
    ASSERT_EQ(update(filter, now += kFrame, kNotSeen).status, PoseStatus::kPredicted);
  }
  // So near that the gate, wide by now, lets it pass.
  CylinderPose near = cylinder.advance(kFrame);
  near.center_in_cam.x() += 0.08;
  const PoseEstimate one = update(filter, now += kFrame, measure(near));
  EXPECT_EQ(one.status, PoseStatus::kPredicted);
  EXPECT_LT(error(one), 0.04);
  EXPECT_EQ(next_right().status, PoseStatus::kPredicted);
  EXPECT_EQ(next_right().status, PoseStatus::kPredicted);
  const PoseEstimate again = next_right();
  EXPECT_EQ(again.status, PoseStatus::kOk);
  EXPECT_LT(error(again), kOnTrack);
}

TEST_F(PoseFilterTest, ATrackStartsWithThreeMeasurementsThatAgree) {
  Measuring measure(1);
  PoseFilter filter = made();
  EXPECT_EQ(update(filter, now += kFrame, kNotSeen).status, PoseStatus::kNone);
  for (int i = 0; i < 10; ++i) {
    const PoseEstimate measured = wrong(measure, i);
    const PoseEstimate passed = update(filter, now += kFrame, measured);
    EXPECT_EQ(passed.status, PoseStatus::kOk);
    EXPECT_EQ(passed.pose.center_in_cam, measured.pose.center_in_cam);
    EXPECT_EQ(passed.covariance, measured.covariance);
    EXPECT_NEAR(std::abs(passed.pose.axis_in_cam.dot(measured.pose.axis_in_cam)), 1, 1e-12);
    EXPECT_EQ(filter.search_region(now), whole);
  }
  MovingCylinder cylinder({}, 1);
  for (int i = 0; i < 3; ++i) {
    EXPECT_EQ(filter.search_region(now), whole);
    update(filter, now += kFrame, measure(cylinder.advance(kFrame)));
  }
  EXPECT_NE(filter.search_region(now), whole);
}

TEST_F(PoseFilterTest, WhatFliesPastTheCameraIsLost) {
  MovingCylinder::Motion motion;
  motion.start = {{0, 0, 1.2}, -Eigen::Vector3d::UnitY()};
  motion.velocity = {0, 0, -1};
  MovingCylinder cylinder(motion, 1);
  Measuring measure(1);
  PoseFilter filter = made();
  follow(filter, cylinder, measure, 0.5);
  for (PoseEstimate coasting = update(filter, now += kFrame, kNotSeen); coasting.status != PoseStatus::kNone;
       coasting = update(filter, now += kFrame, kNotSeen)) {
    ASSERT_GT(coasting.pose.center_in_cam.z(), part.radius_m);
  }
  EXPECT_LT(now, 1.3);
}

}  // namespace
}  // namespace cylpose
