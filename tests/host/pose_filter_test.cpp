#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cylpose/error.hpp>
#include <cylpose/estimator.hpp>
#include <cylpose/image_cv.hpp>
#include <cylpose/outline.hpp>
#include <cylpose/pose_filter.hpp>
#include <cylpose/render.hpp>
#include <cylpose/scenario.hpp>
#include <cylpose/search_region.hpp>
#include <limits>
#include <random>
#include <string>

#include "pose_filter_fixture.hpp"

namespace cylpose {
namespace {

using testing::axis_angle;
using testing::kFrame;
using testing::kNotSeen;
using testing::matched;
using testing::Measuring;
using testing::MovingCylinder;
using testing::normalised_error;
using testing::PoseFilterTest;
using testing::wrong;

TEST_F(PoseFilterTest, IsSmootherThanTheMeasurements) {
  const MovingCylinder::Motion motion{.velocity_drift = 0.02, .rate_drift = 0.05};
  MovingCylinder cylinder(motion, 1);
  Measuring measure(1);
  PoseFilter filter = made(matched(0.02, 0.05));
  double raw_center = 0;
  double raw_axis = 0;
  double center = 0;
  double axis = 0;
  for (int i = 1; i <= 600; ++i) {
    const CylinderPose truth = cylinder.advance(kFrame);
    const PoseEstimate measured = measure(truth);
    const PoseEstimate filtered = update(filter, i * kFrame, measured);
    raw_center += (measured.pose.center_in_cam - truth.center_in_cam).squaredNorm();
    raw_axis += std::pow(axis_angle(measured.pose.axis_in_cam, truth.axis_in_cam), 2);
    center += (filtered.pose.center_in_cam - truth.center_in_cam).squaredNorm();
    axis += std::pow(axis_angle(filtered.pose.axis_in_cam, truth.axis_in_cam), 2);
  }
  RecordProperty("center_rms_ratio", std::to_string(std::sqrt(center / raw_center)));
  RecordProperty("axis_rms_ratio", std::to_string(std::sqrt(axis / raw_axis)));
  EXPECT_LT(std::sqrt(center / raw_center), 0.6);
  EXPECT_LT(std::sqrt(axis / raw_axis), 0.6);
}

// Mean of the normalised error squared over `kRuns` motions that the model fits: within its 95 % band (5 degrees of
// freedom, variance 10 in one run).
class PoseFilterConsistency : public PoseFilterTest {
 protected:
  static constexpr int kRuns = 400;
  static constexpr double kBand = 1.96 * 3.1623 / 20;  // 1.96 sqrt(10 / kRuns)

  struct Means {
    double following = 0;
    double coasting = 0;
  };
  Means means(double velocity_drift, double rate_drift) {
    Means sum;
    FilterOptions options = matched(velocity_drift, rate_drift);
    options.max_axis_sigma_deg = 60;
    options.gate_chi2 = 1e3;  // cut tails would lower the mean
    for (unsigned run = 0; run < kRuns; ++run) {
      MovingCylinder::Motion motion;
      motion.start.center_in_cam.z() = 20;  // never behind the camera
      motion.velocity_drift = velocity_drift;
      motion.rate_drift = rate_drift;
      MovingCylinder cylinder(motion, 2 * run);
      Measuring measure(2 * run + 1);
      PoseFilter filter = made(options);
      now = 0;
      sum.following += normalised_error(follow(filter, cylinder, measure, 1.5), cylinder.pose());
      PoseEstimate coasting;
      for (int i = 0; i < 15; ++i) coasting = update(filter, now += kFrame, kNotSeen);
      EXPECT_EQ(coasting.status, PoseStatus::kPredicted);
      sum.coasting += normalised_error(coasting, cylinder.advance(15 * kFrame));
    }
    return {sum.following / kRuns, sum.coasting / kRuns};
  }
};

TEST_F(PoseFilterConsistency, SlowMotion) {
  const Means found = means(0.02, 0.05);
  EXPECT_NEAR(found.following, 5, kBand);
  EXPECT_NEAR(found.coasting, 5, kBand);
}

TEST_F(PoseFilterConsistency, FastMotion) {
  const Means found = means(0.5, 1);
  EXPECT_NEAR(found.following, 5, kBand);
  EXPECT_NEAR(found.coasting, 5, kBand);
}

// Turns about one axis: once around, through the directions at which the fixed sign jumps.
TEST_F(PoseFilterTest, TheSignOfTheAxisGoesOnWhereTheFixedRuleJumps) {
  const Eigen::Vector3d about[] = {{1, 0, 0}, {0, 0, 1}, {0.6, 0, 0.8}, {0, 1, 0}};
  for (const Eigen::Vector3d& turn : about) {
    MovingCylinder::Motion motion;
    motion.start.axis_in_cam = Eigen::Vector3d(0.8, turn.y() > 0 ? 0 : -1, -0.6);
    motion.start.axis_in_cam = (motion.start.axis_in_cam - motion.start.axis_in_cam.dot(turn) * turn).normalized();
    motion.rate = 2 * turn;
    MovingCylinder cylinder(motion, 1);
    Measuring measure(1);
    PoseFilter filter = made();
    Eigen::Vector3d last = Eigen::Vector3d::Zero();
    int jumps = 0;
    Eigen::Vector3d last_measured = Eigen::Vector3d::Zero();
    double turned = 0;
    for (int i = 1; i <= 100; ++i) {
      const PoseEstimate measured = measure(cylinder.advance(kFrame));
      const PoseEstimate filtered = update(filter, i * kFrame, measured);
      EXPECT_EQ(filtered.status, PoseStatus::kOk) << i;
      if (i > 1) {
        EXPECT_GT(filtered.pose.axis_in_cam.dot(last), 0.98) << i;
        turned += std::acos(std::min(1.0, filtered.pose.axis_in_cam.dot(last)));
        if (measured.pose.axis_in_cam.dot(last_measured) < 0) ++jumps;
      }
      EXPECT_LT(normalised_error(filtered, cylinder.pose()), 20.5) << i;
      last = filtered.pose.axis_in_cam;
      last_measured = measured.pose.axis_in_cam;
    }
    EXPECT_GE(jumps, 1) << "the case shows nothing";
    EXPECT_GT(turned, 2 * M_PI);
  }
}

TEST_F(PoseFilterTest, TheSignGoesOnWithoutATrack) {
  PoseFilter filter = made();
  PoseEstimate measured = Measuring(1)({{0, 0, 1.5}, Eigen::Vector3d(0.8, -0.6, 0)});
  const Eigen::Vector3d first = update(filter, 1, measured).pose.axis_in_cam;
  measured.pose.axis_in_cam = -measured.pose.axis_in_cam;
  EXPECT_GT(update(filter, 2.5, measured).pose.axis_in_cam.dot(first), 0.9);
  filter.reset();
  EXPECT_EQ(update(filter, 1, measured).pose.axis_in_cam, measured.pose.axis_in_cam);
}

TEST_F(PoseFilterTest, TheSignGoesOnWhenATrackIsTakenUpAgain) {
  PoseFilter filter = made();
  PoseEstimate measured = Measuring(1)({{0, 0, 1.5}, Eigen::Vector3d(0.8, -0.6, 0)});
  const Eigen::Vector3d first = measured.pose.axis_in_cam;
  for (int i = 0; i < 5; ++i) update(filter, now += kFrame, measured);
  for (int i = 0; i < 5; ++i) update(filter, now += kFrame, kNotSeen);
  measured.pose.axis_in_cam = -first;
  for (int i = 0; i < 5; ++i) {
    const PoseEstimate filtered = update(filter, now += kFrame, measured);
    EXPECT_EQ(filtered.status, i < 2 ? PoseStatus::kPredicted : PoseStatus::kOk) << i;
    EXPECT_GT(filtered.pose.axis_in_cam.dot(first), 0.9) << i;
  }
}

TEST_F(PoseFilterTest, IrregularTimesGiveTheSameMotion) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> spacing(0.002, 0.15);
  const auto at = [](double time) {
    MovingCylinder cylinder({}, 1);
    return cylinder.advance(time);
  };
  const auto exact = [&](double time) {
    PoseEstimate measured = Measuring(1, 1e-4)(at(time));
    measured.pose = at(time);
    return measured;
  };
  PoseFilter regular = made();
  PoseFilter irregular = made();
  for (int i = 1; i < 60; ++i) update(regular, i * kFrame, exact(i * kFrame));
  for (double time = spacing(random); time < 2; time += spacing(random)) update(irregular, time, exact(time));
  const PoseEstimate a = update(regular, 2.3, kNotSeen);
  const PoseEstimate b = update(irregular, 2.3, kNotSeen);
  ASSERT_EQ(a.status, PoseStatus::kPredicted);
  ASSERT_EQ(b.status, PoseStatus::kPredicted);
  for (const PoseEstimate& predicted : {a, b}) {
    EXPECT_LT((predicted.pose.center_in_cam - at(2.3).center_in_cam).norm(), 1e-4);
    EXPECT_LT(axis_angle(predicted.pose.axis_in_cam, at(2.3).axis_in_cam), 1e-3);
  }
}

TEST_F(PoseFilterTest, FramesWithoutAMeasurementChangeNothing) {
  MovingCylinder cylinder({}, 1);
  PoseFilter one_step = made();
  PoseFilter many_steps = made();
  for (PoseFilter* filter : {&one_step, &many_steps}) {
    MovingCylinder same = cylinder;
    Measuring measure(1);
    now = 0;
    follow(*filter, same, measure, 1);
  }
  for (int i = 1; i < 10; ++i) update(many_steps, now + 0.03 * i + 0.001 * (i % 3), kNotSeen);
  const PoseEstimate a = update(one_step, now + 0.4, kNotSeen);
  const PoseEstimate b = update(many_steps, now + 0.4, kNotSeen);
  ASSERT_EQ(a.status, PoseStatus::kPredicted);
  EXPECT_LT((a.pose.center_in_cam - b.pose.center_in_cam).norm(), 1e-12);
  EXPECT_LT((a.pose.axis_in_cam - b.pose.axis_in_cam).norm(), 1e-12);
  // The noise within a step is taken to be the plane's, not the sphere's.
  EXPECT_TRUE(a.covariance.isApprox(b.covariance, 1e-4));
}

TEST_F(PoseFilterTest, TheCovarianceScaleWidensEveryMeasurement) {
  FilterOptions options;
  options.confirm_frames = 1;
  options.covariance_scale = 9;
  PoseFilter filter = made(options);
  const PoseEstimate measured = Measuring(1)({{0, 0, 1.5}, -Eigen::Vector3d::UnitY()});
  const PoseEstimate filtered = update(filter, 1, measured);
  EXPECT_NEAR(filtered.covariance(2, 2), 9 * measured.covariance(2, 2), 1e-12);
  EXPECT_NEAR(filtered.sigma_axis_rad(), 3 * measured.sigma_axis_rad(), 1e-9);
}

TEST_F(PoseFilterTest, PredictionsHaveTheSidesOfTheirPose) {
  MovingCylinder cylinder({}, 1);
  Measuring measure(1);
  PoseFilter filter = made();
  follow(filter, cylinder, measure, 1);
  const PoseEstimate predicted = update(filter, now += kFrame, kNotSeen);
  const auto outline = Outline::of(camera, part, predicted.pose);
  ASSERT_TRUE(outline);
  for (std::size_t side = 0; side < 2; ++side) {
    EXPECT_EQ(predicted.sides[side].normal, outline->sides()[side].normal);
    EXPECT_EQ(predicted.sides[side].distance, outline->sides()[side].distance);
  }
  EXPECT_EQ(predicted.rms_px, 0);
  EXPECT_EQ(predicted.seen, 0);
}

TEST_F(PoseFilterTest, ThePlaceAlongTheLineOfSightHasNoSidesAndNoTrouble) {
  Measuring measure(1);
  PoseFilter filter = made();
  const CylinderPose end_on{{0, 0, 1.5}, Eigen::Vector3d::UnitZ()};
  for (int i = 0; i < 5; ++i) {
    const PoseEstimate filtered = update(filter, now += kFrame, measure(end_on));
    EXPECT_LT(normalised_error(filtered, end_on), 20.5);
  }
  const PoseEstimate predicted = update(filter, now += kFrame, kNotSeen);
  EXPECT_EQ(predicted.status, PoseStatus::kPredicted);
  EXPECT_TRUE(predicted.sides[0].normal.isZero());
  EXPECT_EQ(united(filter.search_region(now), outline_box(camera, part, end_on)), filter.search_region(now));
}

// A cylinder turns before the camera, at half the scenario's resolution; for a second the camera sees nothing.
TEST_F(PoseFilterTest, FollowsARenderedCylinderThroughASecondOfDarkness) {
  const Scenario& scenario = find_scenario("series3");
  const auto scene_of = [&](int frame) {
    Scene scene = scenario.scene(frame);
    scene.camera.width /= 2;
    scene.camera.height /= 2;
    for (double* pixels : {&scene.camera.fx, &scene.camera.fy}) *pixels /= 2;
    for (double* pixels : {&scene.camera.cx, &scene.camera.cy}) *pixels = *pixels / 2 - 0.25;
    return scene;
  };
  const CameraModel half = scene_of(0).camera;
  const auto estimator = make_estimator("default", half, scenario.parts, "serial");
  PoseFilter filter(half, scenario.parts);
  Eigen::Vector3d last_axis = Eigen::Vector3d::Zero();
  Eigen::Vector3d last_measured_axis = Eigen::Vector3d::Zero();
  constexpr int kDarkFrom = 38;
  constexpr int kDarkTo = 48;  // of a sequence at 10 Hz
  for (int frame = 30; frame < 56; ++frame) {
    const Scene scene = scene_of(frame);
    const CylinderPose& truth = scene.parts[0].cylinder.pose;
    const bool dark = frame >= kDarkFrom && frame < kDarkTo;
    const cv::Mat image = dark ? cv::Mat(half.height, half.width, CV_8UC3, cv::Scalar(0, 0, 0))
                               : degrade(render(scene), {.seed = static_cast<std::uint64_t>(frame)});
    const FrameEstimate measured = estimator->estimate(view_of(image));
    const double time = frame / scenario.frame_rate_hz;
    if (frame > 32) {
      EXPECT_EQ(united(filter.search_region(time), outline_box(half, scenario.parts[0], truth)),
                filter.search_region(time))
          << frame;
    }
    const PoseEstimate filtered = filter.update(time, measured.parts).front();
    const bool coasts = frame >= kDarkFrom && frame < kDarkTo + 2;
    EXPECT_EQ(filtered.status, coasts ? PoseStatus::kPredicted : PoseStatus::kOk) << frame;
    if (frame > 30) {
      EXPECT_GT(filtered.pose.axis_in_cam.dot(last_axis), 0.98) << frame;
    }
    EXPECT_LT(axis_angle(filtered.pose.axis_in_cam, truth.axis_in_cam), coasts ? 0.03 : 0.01) << frame;
    EXPECT_LT((filtered.pose.center_in_cam - truth.center_in_cam).norm(), coasts ? 0.01 : 0.003) << frame;
    EXPECT_LT(normalised_error(filtered, truth), 20.5) << frame;
    last_axis = filtered.pose.axis_in_cam;
    last_measured_axis = measured.parts[0].pose.axis_in_cam;
  }
  EXPECT_LT(last_axis.dot(last_measured_axis), 0) << "no fixed sign jumped: the case shows less than it could";
}

TEST_F(PoseFilterTest, RefusesTimesThatDoNotIncreaseAndGoesOn) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  MovingCylinder cylinder({}, 1);
  Measuring measure(1);
  PoseFilter filter = made();
  EXPECT_THROW(update(filter, kNan, kNotSeen), Error);
  follow(filter, cylinder, measure, 1);
  const Roi region = filter.search_region(now);
  const PoseEstimate elsewhere = wrong(measure, 3);
  for (const double time :
       {now, now - 1, kNan, -std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()}) {
    EXPECT_THROW(update(filter, time, elsewhere), Error) << time;
  }
  EXPECT_THROW((void)filter.search_region(now - 1e-3), Error);
  EXPECT_THROW((void)filter.search_region(kNan), Error);
  EXPECT_EQ(filter.search_region(now), region);
  EXPECT_EQ(update(filter, now + kFrame, measure(cylinder.advance(kFrame))).status, PoseStatus::kOk);
}

TEST_F(PoseFilterTest, RefusesWhatIsNoMeasurement) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  PoseFilter filter = made();
  const PoseEstimate good = Measuring(1)({{0, 0, 1.5}, -Eigen::Vector3d::UnitY()});
  const auto refused = [&](auto change) {
    PoseEstimate bad = good;
    change(bad);
    try {
      update(filter, 1, bad);
    } catch (const Error& error) {
      return error.kind() == ErrorKind::kInput && std::string(error.what()).find(part.name) != std::string::npos;
    }
    return false;
  };
  EXPECT_TRUE(refused([](PoseEstimate& e) { e.status = PoseStatus::kPredicted; }));
  EXPECT_TRUE(refused([](PoseEstimate& e) { e.pose.center_in_cam.y() = kNan; }));
  EXPECT_TRUE(refused([](PoseEstimate& e) { e.pose.axis_in_cam.z() = kNan; }));
  EXPECT_TRUE(refused([](PoseEstimate& e) { e.pose.axis_in_cam *= 1.01; }));
  EXPECT_TRUE(refused([](PoseEstimate& e) { e.covariance(0, 0) = kNan; }));
  EXPECT_TRUE(refused([](PoseEstimate& e) { e.covariance(1, 1) = std::numeric_limits<double>::infinity(); }));
  EXPECT_TRUE(refused([](PoseEstimate& e) { e.covariance(2, 2) = -1; }));
  EXPECT_TRUE(refused([](PoseEstimate& e) { e.covariance.setZero(); }));
  EXPECT_THROW((void)filter.update(1, {}), Error);
  EXPECT_THROW((void)filter.update(1, std::array{good, good}), Error);
  // Of a part that is not seen nothing is read.
  PoseEstimate none = kNotSeen;
  none.pose.center_in_cam.x() = kNan;
  EXPECT_EQ(update(filter, 1, none).status, PoseStatus::kNone);
}

TEST_F(PoseFilterTest, RefusesOptionsCamerasAndPartsThatCannotBe) {
  std::string why;
  EXPECT_TRUE(FilterOptions().is_valid(&why)) << why;
  EXPECT_TRUE(FilterOptions::hand_held().is_valid(&why)) << why;
  for (double FilterOptions::*field :
       {&FilterOptions::velocity_drift_m_s, &FilterOptions::rate_drift_rad_s, &FilterOptions::start_speed_m_s,
        &FilterOptions::start_rate_rad_s, &FilterOptions::covariance_scale, &FilterOptions::gate_chi2,
        &FilterOptions::max_coast_s, &FilterOptions::max_center_sigma_m, &FilterOptions::max_axis_sigma_deg}) {
    for (const double value :
         {0.0, -1.0, std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
      FilterOptions options;
      options.*field = value;
      why.clear();
      EXPECT_FALSE(options.is_valid(&why)) << value;
      EXPECT_FALSE(why.empty());
      EXPECT_THROW(made(options), Error);
    }
  }
  FilterOptions options;
  options.confirm_frames = 0;
  EXPECT_FALSE(options.is_valid(&why));
  options = {};
  options.switch_frames = options.confirm_frames - 1;
  EXPECT_FALSE(options.is_valid(&why));

  EXPECT_THROW(PoseFilter(CameraModel(), {part}), Error);
  EXPECT_THROW(PoseFilter(camera, {}), Error);
  PartModel flat = part;
  flat.height_m = 0;
  EXPECT_THROW(PoseFilter(camera, {flat}), Error);
}

}  // namespace
}  // namespace cylpose
