#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cylpose/error.hpp>
#include <cylpose/render.hpp>
#include <cylpose/scenario.hpp>
#include <numbers>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <set>

#include "scene_pictures.hpp"

namespace cylpose {
namespace {

double sight_angle_deg(const CylinderPose& pose) {
  const double cosine = std::abs(pose.axis_in_cam.dot(pose.center_in_cam.normalized()));
  return std::acos(std::min(1.0, cosine)) * 180 / std::numbers::pi;
}

CylinderPose pose_of(const Scenario& scenario, int frame, int frames) {
  return scenario.scene(frame, frames).parts.at(0).cylinder.pose;
}

void expect_inside_image(const Scene& scene) {
  for (const Eigen::Vector2d& pixel : outline_px(scene)) {
    ASSERT_GE(pixel.x(), 2);
    ASSERT_GE(pixel.y(), 2);
    ASSERT_LE(pixel.x(), scene.camera.width - 3);
    ASSERT_LE(pixel.y(), scene.camera.height - 3);
  }
}

// The gate takes what the part covers and nothing else.
void expect_gate_selects_part(const Scene& scene, const PartModel& part, const DegradeOptions& options) {
  const cv::Mat image = degrade(render(scene), options);
  const cv::Mat coverage = render_coverage(scene, 0);
  cv::Mat near_part;
  cv::dilate(coverage > 0, near_part, cv::getStructuringElement(cv::MORPH_RECT, {7, 7}));
  int inside = 0;
  int inside_taken = 0;
  int outside = 0;
  int outside_taken = 0;
  for (int y = 0; y < image.rows; ++y) {
    for (int x = 0; x < image.cols; ++x) {
      const bool taken = has_color_of(part, image.at<cv::Vec3b>(y, x));
      if (coverage.at<float>(y, x) == 1) {
        ++inside;
        inside_taken += taken ? 1 : 0;
      } else if (near_part.at<std::uint8_t>(y, x) == 0) {
        ++outside;
        outside_taken += taken ? 1 : 0;
      }
    }
  }
  ASSERT_GT(inside, 200);
  EXPECT_GT(inside_taken, 0.95 * inside);
  EXPECT_LT(outside_taken, 0.01 * outside);
}

class EveryScenario : public testing::TestWithParam<std::string> {
 protected:
  const Scenario& scenario_ = find_scenario(GetParam());
};

TEST_P(EveryScenario, DescribesItself) {
  EXPECT_FALSE(scenario_.description.empty());
  EXPECT_GE(scenario_.frames, 1);
  EXPECT_GT(scenario_.frame_rate_hz, 0);
  std::string why;
  EXPECT_TRUE(scenario_.camera.is_valid(&why)) << why;
  ASSERT_EQ(scenario_.parts.size(), 1U);
  EXPECT_TRUE(scenario_.parts[0].is_valid(&why)) << why;
  EXPECT_EQ(scenario_.camera.width, 1280);
  EXPECT_EQ(scenario_.camera.height, 720);
  EXPECT_EQ(scenario_.camera.fx, 1215);
  EXPECT_EQ(scenario_.camera.cx, 639.5);
}

TEST_P(EveryScenario, ShowsThePartInsideTheImage) {
  for (int frame = 0; frame < scenario_.frames; ++frame) {
    const Scene scene = scenario_.scene(frame);
    ASSERT_EQ(scene.parts.size(), 1U);
    EXPECT_EQ(scene.parts[0].cylinder.radius_m, scenario_.parts[0].radius_m);
    EXPECT_EQ(scene.parts[0].cylinder.height_m, scenario_.parts[0].height_m);
    EXPECT_NEAR(scene.parts[0].cylinder.pose.axis_in_cam.norm(), 1, 1e-12);
    if (scenario_.name != "along") {
      EXPECT_GT(sight_angle_deg(scene.parts[0].cylinder.pose), 28) << "frame " << frame;
    }
    expect_inside_image(scene);
    ASSERT_FALSE(HasFatalFailure()) << "frame " << frame;
  }
}

TEST_P(EveryScenario, GateSelectsThePart) {
  const std::vector<int> frames =
      scenario_.frames == 1 ? std::vector<int>{0} : std::vector<int>{0, scenario_.frames / 3, scenario_.frames - 1};
  for (const int frame : frames) {
    SCOPED_TRACE("frame " + std::to_string(frame));
    expect_gate_selects_part(scenario_.scene(frame), scenario_.parts[0],
                             {scenario_.blur_sigma_px, scenario_.noise_sigma, scenario_.camera.transfer, 1});
  }
}

std::vector<std::string> names() {
  std::vector<std::string> all;
  for (const Scenario& scenario : scenarios()) all.push_back(scenario.name);
  return all;
}

INSTANTIATE_TEST_SUITE_P(Scenario, EveryScenario, testing::ValuesIn(names()), [](const auto& named) {
  std::string name = named.param;
  std::replace(name.begin(), name.end(), '.', '_');  // GoogleTest takes no dots
  return name;
});

TEST(Scenario, NamesAreKnown) {
  EXPECT_THAT(names(),
              testing::ElementsAre("fig5.2", "fig5.3", "fig5.4", "fig5.5", "fig5.6", "fig5.7", "series1", "series2",
                                   "series3", "series4", "manipulator", "occlusion", "along", "candle"));
  try {
    (void)find_scenario("series5");
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::kInput);
    EXPECT_THAT(error.what(), testing::HasSubstr("series5"));
    EXPECT_THAT(error.what(), testing::HasSubstr("candle"));
  }
}

TEST(Scenario, FramesOutsideTheMotionAreRefused) {
  const Scenario& scenario = find_scenario("series1");
  EXPECT_THROW((void)scenario.scene(-1, 10), Error);
  EXPECT_THROW((void)scenario.scene(10, 10), Error);
  EXPECT_THROW((void)scenario.scene(0, 0), Error);
}

TEST(Scenario, AnotherNumberOfFramesIsTheSameMotion) {
  const Scenario& scenario = find_scenario("series4");
  EXPECT_EQ(pose_of(scenario, 0, 100).center_in_cam, pose_of(scenario, 0, 12).center_in_cam);
  EXPECT_EQ(pose_of(scenario, 99, 100).center_in_cam, pose_of(scenario, 11, 12).center_in_cam);
  EXPECT_EQ(pose_of(scenario, 33, 100).axis_in_cam, pose_of(scenario, 3, 10).axis_in_cam);
  // ... in the same time.
  EXPECT_NEAR(99 / scenario.rate_for(100), 11 / scenario.rate_for(12), 1e-12);
}

TEST(Scenario, SeriesOneAndTwoApproachFromFiveMetresToBelowOne) {
  for (const char* name : {"series1", "series2"}) {
    const Scenario& scenario = find_scenario(name);
    const CylinderPose first = pose_of(scenario, 0, 100);
    const CylinderPose last = pose_of(scenario, 99, 100);
    EXPECT_NEAR(first.center_in_cam.z(), 5, 1e-12);
    EXPECT_LT(last.center_in_cam.z(), 1);
    const double step = pose_of(scenario, 1, 100).center_in_cam.z() - first.center_in_cam.z();
    for (int frame = 1; frame < 100; ++frame) {
      const CylinderPose before = pose_of(scenario, frame - 1, 100);
      const CylinderPose pose = pose_of(scenario, frame, 100);
      EXPECT_NEAR(pose.center_in_cam.z() - before.center_in_cam.z(), step, 1e-12);
      EXPECT_EQ(pose.center_in_cam.head<2>(), first.center_in_cam.head<2>());
      EXPECT_EQ(pose.axis_in_cam, first.axis_in_cam);
    }
  }
  EXPECT_EQ(pose_of(find_scenario("series1"), 0, 100).axis_in_cam, Eigen::Vector3d(0, -1, 0));
  const Eigen::Vector3d tilted = pose_of(find_scenario("series2"), 0, 100).axis_in_cam;
  EXPECT_NEAR(tilted.x(), -tilted.y(), 1e-12);
}

TEST(Scenario, SeriesThreeTurnsInPlace) {
  const Scenario& scenario = find_scenario("series3");
  double turned_deg = 0;
  for (int frame = 0; frame < 100; ++frame) {
    const CylinderPose pose = pose_of(scenario, frame, 100);
    EXPECT_NEAR(pose.center_in_cam.z(), 1.5, 1e-12);
    EXPECT_EQ(pose.center_in_cam, pose_of(scenario, 0, 100).center_in_cam);
    EXPECT_NEAR(pose.axis_in_cam.z(), 0, 1e-12);
    if (frame > 0) {
      const double cosine = pose.axis_in_cam.dot(pose_of(scenario, frame - 1, 100).axis_in_cam);
      turned_deg += std::acos(std::min(1.0, cosine)) * 180 / std::numbers::pi;
    }
  }
  EXPECT_NEAR(turned_deg, 180, 0.1);
}

TEST(Scenario, SeriesFourTumblesBelowOneMetre) {
  const Scenario& scenario = find_scenario("series4");
  double least = 90;
  double most = 0;
  for (int frame = 0; frame < 100; ++frame) {
    const CylinderPose pose = pose_of(scenario, frame, 100);
    EXPECT_LT(pose.center_in_cam.norm(), 1);
    least = std::min(least, sight_angle_deg(pose));
    most = std::max(most, sight_angle_deg(pose));
  }
  EXPECT_GT(least, 28);
  EXPECT_LT(least, 40);
  EXPECT_GT(most, 80);
  EXPECT_GT((pose_of(scenario, 0, 100).center_in_cam - pose_of(scenario, 99, 100).center_in_cam).norm(), 0.2);
}

double visible_share(Scene scene) {
  const double seen = cv::sum(render_coverage(scene, 0))[0];
  scene.others.clear();
  return seen / cv::sum(render_coverage(scene, 0))[0];
}

TEST(Scenario, OcclusionHidesFromNothingToHalf) {
  const Scenario& scenario = find_scenario("occlusion");
  EXPECT_EQ(visible_share(scenario.scene(0, 11)), 1);
  double before = 1;
  for (int frame = 1; frame < 8; ++frame) {
    const double share = visible_share(scenario.scene(frame, 11));
    EXPECT_LE(share, before + 1e-3);
    before = share;
  }
  EXPECT_NEAR(before, 0.5, 0.05);
  EXPECT_NEAR(visible_share(scenario.scene(10, 11)), 0.5, 0.05);
}

TEST(Scenario, FiguresOfOcclusionAreOccluded) {
  const double near_end_hidden = visible_share(find_scenario("fig5.5").scene(0));
  EXPECT_GT(near_end_hidden, 0.6);
  EXPECT_LT(near_end_hidden, 0.9);
  EXPECT_LT(visible_share(find_scenario("fig5.7").scene(0)), 0.45);
  EXPECT_GT(pose_of(find_scenario("fig5.7"), 0, 1).center_in_cam.z(), 4);
}

TEST(Scenario, CandleLiesAtItsDistance) {
  const Scenario& scenario = find_scenario("candle");
  EXPECT_EQ(scenario.parts[0].radius_m, 0.0395);
  EXPECT_EQ(scenario.parts[0].height_m, 0.27);
  for (int frame = 0; frame < 50; ++frame) EXPECT_NEAR(pose_of(scenario, frame, 100).center_in_cam.z(), 1.1, 1e-12);
  EXPECT_NEAR(pose_of(scenario, 99, 100).center_in_cam.z(), 0.6, 1e-12);
}

TEST(RandomScene, KeepsItsPromises) {
  std::set<TextureKind> backgrounds;
  double nearest = 10;
  double farthest = 0;
  for (std::uint64_t seed = 0; seed < 500; ++seed) {
    const RandomScene random = random_scene(seed);
    const CylinderPose& pose = random.scene.parts.at(0).cylinder.pose;
    EXPECT_GT(sight_angle_deg(pose), 28);
    nearest = std::min(nearest, pose.center_in_cam.norm());
    farthest = std::max(farthest, pose.center_in_cam.norm());
    std::string why;
    EXPECT_TRUE(random.part.is_valid(&why)) << why;
    EXPECT_TRUE(random.degrade.is_valid(&why)) << why;
    backgrounds.insert(random.scene.background.kind);
    expect_inside_image(random.scene);
    ASSERT_FALSE(HasFatalFailure()) << "seed " << seed;
  }
  EXPECT_GE(nearest, 0.8);
  EXPECT_LT(nearest, 1);
  EXPECT_LE(farthest, 5);
  EXPECT_GT(farthest, 4.8);
  EXPECT_EQ(backgrounds.size(), 6U);
}

TEST(RandomScene, SeedDecides) {
  const auto center = [](std::uint64_t seed) {
    return random_scene(seed).scene.parts.at(0).cylinder.pose.center_in_cam;
  };
  EXPECT_EQ(center(7), center(7));
  EXPECT_GT((center(7) - center(8)).norm(), 1e-3);
}

TEST(RandomScene, GateSelectsThePart) {
  for (std::uint64_t seed = 0; seed < 12; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const RandomScene random = random_scene(seed);
    expect_gate_selects_part(random.scene, random.part, random.degrade);
  }
}

}  // namespace
}  // namespace cylpose
