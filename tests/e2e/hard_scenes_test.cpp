// What makes a part hard to see, one thing at a time, over several poses: found where it can be, and never wrong.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cylpose/estimator.hpp>
#include <cylpose/image_cv.hpp>
#include <cylpose/render.hpp>
#include <cylpose/scenario.hpp>
#include <functional>
#include <numbers>
#include <ostream>
#include <string>
#include <vector>

namespace cylpose {
namespace {

constexpr double kDegree = std::numbers::pi / 180;
constexpr double kHueDeg = 215;
constexpr double kRadiusM = 0.05;
constexpr double kHeightM = 0.4;

PartModel part() {
  return {"link", kRadiusM, kHeightM, kHueDeg - 25, kHueDeg + 25, 0.2, 0.1};
}

Material paint() {
  Material material;
  material.texture.color = linear_from_hsv(kHueDeg, 0.9, 0.85);
  material.specular = 0.1;
  return material;
}

Material grey(double light) {
  Material material;
  material.texture.color = LinearRgb::Constant(light);
  return material;
}

Scene plain_scene(const CylinderPose& pose) {
  Scene scene;
  scene.camera = scenario_camera();
  scene.background.color = LinearRgb::Constant(0.3);
  scene.parts = {{{pose, kRadiusM, kHeightM}, paint()}};
  return scene;
}

// A box nearer to the camera that hides a piece of the part: from `from` to `to` along the axis and from `left` to
// `right` across it, in metres from the part's centre.
Solid cover(const CylinderPose& pose, double from, double to, double left, double right) {
  constexpr double kNearness = 0.7;
  const Eigen::Vector3d sight = pose.center_in_cam.normalized();
  const Eigen::Vector3d across = pose.axis_in_cam.cross(sight).normalized();
  BoxSolid box;
  box.center_in_cam =
      kNearness * (pose.center_in_cam + (from + to) / 2 * pose.axis_in_cam + (left + right) / 2 * across);
  box.cam_from_box << pose.axis_in_cam, across, pose.axis_in_cam.cross(across);
  box.half_size_m = {kNearness * (to - from) / 2, kNearness * (right - left) / 2, 0.002};
  return {box, grey(0.15)};
}

struct HardScene {
  std::string name;
  std::function<void(Scene&)> make_hard;
  int least_found;  // of the eight poses
};

void PrintTo(const HardScene& scene, std::ostream* stream) {
  *stream << scene.name;
}

std::vector<HardScene> hard_scenes() {
  const auto pose_of = [](const Scene& scene) { return scene.parts[0].cylinder.pose; };
  return {
      {"AsItIs", [](Scene&) {}, 8},
      {"BarAcross", [=](Scene& s) { s.others.push_back(cover(pose_of(s), -0.05, 0.05, -0.3, 0.3)); }, 8},
      {"OneSideHidden", [=](Scene& s) { s.others.push_back(cover(pose_of(s), -0.3, 0.3, 0.01, 0.2)); }, 0},
      {"OneEndHidden", [=](Scene& s) { s.others.push_back(cover(pose_of(s), 0.1, 0.35, -0.3, 0.3)); }, 7},
      {"BothEndsHidden",
       [=](Scene& s) {
         s.others.push_back(cover(pose_of(s), 0.13, 0.35, -0.3, 0.3));
         s.others.push_back(cover(pose_of(s), -0.35, -0.13, -0.3, 0.3));
       },
       0},
      {"PartlyOutsideTheImage",
       [=](Scene& s) {
         // The camera looks past the part, one end of which leaves the picture.
         const CylinderPose pose = pose_of(s);
         const Eigen::Vector2d end = ideal_pixel(s.camera, pose.center_in_cam + 0.12 * pose.axis_in_cam);
         const Eigen::Vector2d middle = ideal_pixel(s.camera, pose.center_in_cam);
         const Eigen::Vector2d toward = end - middle;
         if (std::abs(toward.x()) > std::abs(toward.y())) {
           s.camera.cx += toward.x() > 0 ? s.camera.width - 1 - end.x() : -end.x();
         } else {
           s.camera.cy += toward.y() > 0 ? s.camera.height - 1 - end.y() : -end.y();
         }
       },
       6},
      {"AnotherOfItsColourCrosses",
       [=](Scene& s) {
         const CylinderPose pose = pose_of(s);
         const Eigen::Vector3d sight = pose.center_in_cam.normalized();
         const Eigen::Vector3d axis = Eigen::AngleAxisd(70 * kDegree, sight) * pose.axis_in_cam;
         s.others.push_back({CylinderSolid{{1.15 * pose.center_in_cam, axis}, 0.03, 0.7}, paint()});
       },
       0},
      {"BackgroundOfNearHue",
       [](Scene& s) {
         s.background = {TextureKind::kNoise, linear_from_hsv(kHueDeg + 45, 0.5, 0.4),
                         linear_from_hsv(kHueDeg + 45, 0.7, 0.7), 0.1, 3};
       },
       7},
      {"SpecularStreaks",
       [](Scene& s) {
         s.parts[0].material.specular = 0.8;
         s.parts[0].material.exponent = 60;
       },
       7},
      {"HardShadowAlongThePart",
       [=](Scene& s) {
         const CylinderPose pose = pose_of(s);
         s.lighting.hard_shadows = true;
         const Eigen::Vector3d light = s.lighting.light_in_cam.normalized();
         const Eigen::Vector3d across = light.cross(pose.axis_in_cam).normalized();
         BoxSolid blade;
         blade.center_in_cam = pose.center_in_cam + 0.6 * light;
         blade.cam_from_box << pose.axis_in_cam, across, pose.axis_in_cam.cross(across);
         blade.half_size_m = {0.3, 0.012, 0.001};
         s.others.push_back({blade, grey(0.4)});
       },
       6},
      {"OneSideHardlyLit",
       [](Scene& s) {
         s.lighting.ambient = 0.06;
         s.lighting.key = 0.9;
         s.lighting.light_in_cam = {-0.95, -0.2, -0.25};
       },
       6},
      {"BlackSky",
       [](Scene& s) {
         s.background.color.setZero();
         s.lighting.ambient = 0.1;
         s.lighting.key = 0.9;
       },
       6},
      {"OverExposed",
       [](Scene& s) {
         s.lighting.ambient = 0.7;
         s.lighting.key = 2.2;
       },
       6},
  };
}

std::vector<CylinderPose> poses() {
  std::vector<CylinderPose> poses;
  for (int i = 0; i < 8; ++i) {
    const double distance_m = i % 2 == 0 ? 1.2 : 2.4;
    const Eigen::Vector3d sight = Eigen::Vector3d(0.04 * (i % 3 - 1), 0.03 * (i % 2), 1).normalized();
    const Eigen::Vector3d across = Eigen::AngleAxisd(0.7 * i, sight) * sight.unitOrthogonal();
    poses.push_back({distance_m * sight, Eigen::AngleAxisd((45 + 12 * (i % 4)) * kDegree, across) * sight});
  }
  return poses;
}

class HardSceneTest : public ::testing::TestWithParam<HardScene> {};

TEST_P(HardSceneTest, FoundWhereItCanBeAndNeverWrong) {
  int found = 0;
  int number = 0;
  std::string reasons;
  for (const CylinderPose& pose : poses()) {
    Scene scene = plain_scene(pose);
    GetParam().make_hard(scene);
    DegradeOptions camera;
    camera.seed = static_cast<std::uint64_t>(++number);
    const cv::Mat image = degrade(render(scene), camera);
    const PoseEstimate estimate =
        make_estimator("default", scene.camera, {part()})->estimate(view_of(image)).parts.at(0);
    if (estimate.status != PoseStatus::kOk) {
      reasons += "\n  " + std::to_string(number) + ": " + estimate.reason;
      continue;
    }
    ++found;
    // What is off by more must say so by its covariance.
    const Eigen::Vector3d error = estimate.pose.center_in_cam - pose.center_in_cam;
    const double sigma_m = std::sqrt(estimate.covariance.topLeftCorner<3, 3>().trace());
    EXPECT_LT(error.norm(), std::max({0.025, 0.02 * pose.center_in_cam.norm(), 4 * sigma_m})) << number;
    const Eigen::Vector3d& axis = estimate.pose.axis_in_cam;
    const double angle = std::atan2(axis.cross(pose.axis_in_cam).norm(), std::abs(axis.dot(pose.axis_in_cam)));
    EXPECT_LT(angle, std::max(10 * kDegree, 4 * estimate.sigma_axis_rad())) << number;
    EXPECT_LT(sigma_m, 0.3) << number;  // but not of just anything
  }
  EXPECT_GE(found, GetParam().least_found) << reasons;
}

INSTANTIATE_TEST_SUITE_P(All, HardSceneTest, ::testing::ValuesIn(hard_scenes()),
                         [](const auto& instance) { return instance.param.name; });

}  // namespace
}  // namespace cylpose
