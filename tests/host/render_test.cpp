#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <cylpose/error.hpp>
#include <cylpose/render.hpp>
#include <limits>
#include <opencv2/core.hpp>

#include "scene_pictures.hpp"

namespace cylpose {
namespace {

std::vector<CylinderPose> various_poses() {
  return {{{0.02, -0.01, 0.8}, -Eigen::Vector3d::UnitY()},
          {{0.1, 0.05, 0.9}, Eigen::Vector3d(0.6, -0.5, 0.4).normalized()},
          {{-0.2, 0.1, 1.5}, Eigen::Vector3d(1, 0, 0)},
          {{-0.05, 0.02, 0.7}, Eigen::Vector3d(-0.3, 0.5, 0.8).normalized()},
          {{0.03, 0.02, 0.9}, Eigen::Vector3d::UnitZ()}};
}

CameraModel with_distortion() {
  CameraModel camera = small_camera();
  camera.distortion_model = DistortionModel::kPlumbBob;
  camera.distortion = {-0.3, 0.12, 0.002, -0.001, 0};
  return camera;
}

// Sharper than 0.1 %: one per cent of a border pixel would be seen.
TEST(Render, CoverageSumsToTheAreaOfTheOutline) {
  for (const CylinderPose& pose : various_poses()) {
    const Scene scene = white_on_black(pose);
    const Polygon truth = measured(outline_px(scene));
    ASSERT_GT(truth.area, 1000);
    EXPECT_NEAR(cv::sum(render_coverage(scene, 0))[0] / truth.area, 1, 1e-3);
  }
}

TEST(Render, CoverageHasTheCentroidOfTheOutline) {
  for (const CylinderPose& pose : various_poses()) {
    const Scene scene = white_on_black(pose);
    const cv::Mat coverage = render_coverage(scene, 0);
    Eigen::Vector2d moment = Eigen::Vector2d::Zero();
    for (int y = 0; y < coverage.rows; ++y) {
      for (int x = 0; x < coverage.cols; ++x) {
        moment += static_cast<double>(coverage.at<float>(y, x)) * Eigen::Vector2d(x, y);
      }
    }
    EXPECT_LT((moment / cv::sum(coverage)[0] - measured(outline_px(scene)).centroid).norm(), 0.01);
  }
}

// Where a closed polygon crosses a row: least and largest x.
std::array<double, 2> crossings(const std::vector<Eigen::Vector2d>& polygon, double y) {
  std::array<double, 2> range = {std::numeric_limits<double>::max(), std::numeric_limits<double>::lowest()};
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Eigen::Vector2d& a = polygon[i];
    const Eigen::Vector2d& b = polygon[(i + 1) % polygon.size()];
    if ((a.y() > y) == (b.y() > y)) continue;
    const double x = a.x() + (b.x() - a.x()) * (y - a.y()) / (b.y() - a.y());
    range = {std::min(range[0], x), std::max(range[1], x)};
  }
  return range;
}

// Both sides in every row of an upright cylinder: their places from the covered share of the pixels.
void expect_sides_where_projected(const Scene& scene, double row_tolerance_px, double mean_tolerance_px) {
  const cv::Mat coverage = render_coverage(scene, 0);
  const auto outline = outline_px(scene);
  const auto middle = static_cast<int>(std::lround(measured(outline).centroid.x()));
  double error_sum = 0;
  int rows = 0;
  for (int y = 80; y < 160; ++y) {
    const cv::Mat row = coverage.row(y);
    const double left = middle + 0.5 - cv::sum(row.colRange(0, middle + 1))[0];
    const double right = middle + 0.5 + cv::sum(row.colRange(middle + 1, row.cols))[0];
    const auto truth = crossings(outline, y);
    EXPECT_NEAR(left, truth[0], row_tolerance_px);
    EXPECT_NEAR(right, truth[1], row_tolerance_px);
    error_sum += left - truth[0] + right - truth[1];
    ++rows;
  }
  EXPECT_NEAR(error_sum / (2 * rows), 0, mean_tolerance_px);
}

TEST(Render, SidesLieWhereTheyAreProjected) {
  expect_sides_where_projected(white_on_black({{0.02, -0.01, 0.6}, -Eigen::Vector3d::UnitY()}), 0.02, 0.002);
  const Eigen::Vector3d slanted = Eigen::Vector3d(0.15, -1, 0.3).normalized();
  expect_sides_where_projected(white_on_black({{0.02, -0.01, 0.6}, slanted}), 0.02, 0.002);
}

TEST(Render, LensDistortionIsHonoured) {
  Scene scene = white_on_black({{0.22, -0.01, 0.6}, -Eigen::Vector3d::UnitY()});
  const auto straight = crossings(outline_px(scene), 120);
  scene.camera = with_distortion();
  const auto bent = crossings(outline_px(scene), 120);
  ASSERT_GT(std::abs(straight[1] - bent[1]), 3);  // or the test would show nothing
  expect_sides_where_projected(scene, 0.02, 0.002);
}

TEST(Render, FisheyeIsHonoured) {
  Scene scene = white_on_black({{0.22, -0.01, 0.6}, -Eigen::Vector3d::UnitY()});
  scene.camera.distortion_model = DistortionModel::kFisheye;
  scene.camera.distortion = {0.02, -0.01, 0, 0};
  expect_sides_where_projected(scene, 0.02, 0.002);
}

TEST(Render, TruthMaskIsWhatRaysHit) {
  const auto bar_in_front =
      Solid{BoxSolid{{0.05, 0, 0.5}, Eigen::Matrix3d::Identity(), {0.03, 0.3, 0.01}}, plain({1, 1, 1})};
  int hidden_in_all = 0;
  for (const CylinderPose& pose : various_poses()) {
    Scene scene = white_on_black(pose);
    scene.others = {bar_in_front};
    const cv::Mat mask = truth_mask(scene, 0);
    const cv::Mat coverage = render_coverage(scene, 0);
    ASSERT_EQ(mask.type(), CV_8UC1);
    int hits = 0;
    int hidden = 0;
    for (int y = 0; y < mask.rows; ++y) {
      for (int x = 0; x < mask.cols; ++x) {
        const Eigen::Vector3d ray((x - scene.camera.cx) / scene.camera.fx, (y - scene.camera.cy) / scene.camera.fy, 1);
        const bool meets_part = intersect_ray(pose, 0.05, 0.4, ray).has_value();
        const Eigen::Vector2d on_bar = 0.49 * ray.head<2>();
        const bool meets_bar = std::abs(on_bar.x() - 0.05) < 0.03 && std::abs(on_bar.y()) < 0.3;
        const float share = coverage.at<float>(y, x);
        EXPECT_EQ(mask.at<std::uint8_t>(y, x), share >= 0.5F ? 255 : 0);
        if (share == 0 || share == 1) {
          EXPECT_EQ(share == 1, meets_part && !meets_bar) << x << "," << y;
          hits += share == 1 ? 1 : 0;
          hidden += meets_part && meets_bar ? 1 : 0;
        }
      }
    }
    EXPECT_GT(hits, 200);
    hidden_in_all += hidden;
  }
  EXPECT_GT(hidden_in_all, 1000);
}

TEST(Render, BordersMixInLinearLight) {
  Scene scene = white_on_black(various_poses()[1]);
  scene.parts[0].material = plain({0.1, 0.5, 0.9});
  scene.background.color = {0.8, 0.2, 0.4};
  const cv::Mat light = render(scene).pixels;
  const cv::Mat coverage = render_coverage(scene, 0);
  ASSERT_EQ(light.type(), CV_32FC3);
  int mixed = 0;
  for (int y = 0; y < light.rows; ++y) {
    for (int x = 0; x < light.cols; ++x) {
      const auto share = static_cast<double>(coverage.at<float>(y, x));
      const cv::Vec3f& bgr = light.at<cv::Vec3f>(y, x);
      EXPECT_NEAR(bgr[0], 0.9 * share + 0.4 * (1 - share), 1e-5);
      EXPECT_NEAR(bgr[1], 0.5 * share + 0.2 * (1 - share), 1e-5);
      EXPECT_NEAR(bgr[2], 0.1 * share + 0.8 * (1 - share), 1e-5);
      mixed += share > 0.1 && share < 0.9 ? 1 : 0;
    }
  }
  EXPECT_GT(mixed, 100);
}

// A wall straight before the camera, wider than the picture.
Scene wall_scene() {
  Scene scene;
  scene.camera = small_camera();
  scene.lighting.ambient = 0.2;
  scene.lighting.key = 0.6;
  scene.lighting.light_in_cam = {0, -3, -4};
  scene.others = {{BoxSolid{{0, 0, 2.1}, Eigen::Matrix3d::Identity(), {5, 5, 0.1}}, plain({0.5, 0.5, 0.5})}};
  return scene;
}

TEST(Render, LambertsLaw) {
  // The light comes with a cosine of 4/5.
  EXPECT_NEAR(render(wall_scene()).pixels.at<cv::Vec3f>(50, 70)[1], 0.5 * (0.2 + 0.6 * 0.8), 1e-6);
}

// Oren and Nayar: seen along the light a rough surface is brighter at its limb than Lambert's law has it, and darker
// in the middle.
TEST(Render, RoughSurfacesAreFlatter) {
  Scene scene = white_on_black({{0, 0, 1}, Eigen::Vector3d::UnitY()});
  scene.lighting = {0, 1, {0, 0, -1}, true, false};
  const cv::Mat smooth = render(scene).pixels;
  scene.parts[0].material.roughness_rad = 0.5;
  const cv::Mat rough = render(scene).pixels;
  const auto ratio = [&](int x) { return rough.at<cv::Vec3f>(119, x)[0] / smooth.at<cv::Vec3f>(119, x)[0]; };
  const double a = 1 - 0.5 * 0.25 / (0.25 + 0.33);
  const double b = 0.45 * 0.25 / (0.25 + 0.09);
  EXPECT_NEAR(ratio(161), a, 0.01);
  // At the angle t from the middle, light and camera both t off the normal: A + B sin t tan t.
  const double t = std::asin(0.965 * (171 - 161.3) / (280 * 0.05));  // 0.965 m: the depth of the surface there
  EXPECT_NEAR(ratio(171), a + b * std::sin(t) * std::tan(t), 0.015);
}

TEST(Render, HighlightWhereTheSurfaceMirrorsTheLight) {
  Scene scene = wall_scene();
  scene.lighting.light_in_cam = {0, 0, -1};
  scene.others[0].material.specular = 0.5;
  scene.others[0].material.exponent = 400;
  const cv::Mat light = render(scene).pixels;
  const double diffuse = 0.5 * (0.2 + 0.6);
  EXPECT_NEAR(light.at<cv::Vec3f>(119, 161)[1], diffuse + 0.6 * 0.5, 0.01);
  EXPECT_NEAR(light.at<cv::Vec3f>(5, 5)[1], diffuse, 0.01);
}

// By the laws of sines and tangents for a ray that meets the surface at the angle t from its normal.
TEST(Render, VarnishMirrorsTheBackgroundTowardTheLimb) {
  const CylinderPose pose{{0, 0, 1}, Eigen::Vector3d::UnitY()};
  Scene scene = white_on_black(pose);
  scene.parts[0].material = plain({0, 0, 0});
  scene.parts[0].material.refractive_index = 1.5;
  scene.lighting.ambient = 0.2;
  scene.background.color = {0.8, 0.8, 0.8};
  const cv::Mat light = render(scene).pixels;
  EXPECT_NEAR(light.at<cv::Vec3f>(119, 161)[0], 0.04 * 0.2, 1e-4);  // what is behind the camera
  for (const int x : {172, 173, 174}) {
    const Eigen::Vector3d ray((x - scene.camera.cx) / scene.camera.fx, (119 - scene.camera.cy) / scene.camera.fy, 1);
    const double t = std::acos(-intersect_ray(pose, 0.05, 0.4, ray).value().normal_in_cam.dot(ray.normalized()));
    const double inside = std::asin(std::sin(t) / 1.5);
    const double across = std::sin(t - inside) / std::sin(t + inside);
    const double along = std::tan(t - inside) / std::tan(t + inside);
    const double mirrored = (across * across + along * along) / 2;
    EXPECT_NEAR(light.at<cv::Vec3f>(119, x)[0], 0.8 * mirrored, 1e-4) << x;
  }
}

TEST(Render, HardShadowsAreAChoice) {
  Scene scene = wall_scene();
  // 0.4 m before the wall, above the middle: the shadow falls 0.3 m further down.
  scene.others.push_back({SphereSolid{{0, -0.3, 1.6}, 0.1}, plain({1, 1, 1})});
  const int shadow_row = static_cast<int>(scene.camera.cy);
  const int shadow_column = static_cast<int>(scene.camera.cx);
  const double lit = 0.5 * (0.2 + 0.6 * 0.8);
  EXPECT_NEAR(render(scene).pixels.at<cv::Vec3f>(shadow_row, shadow_column)[1], lit, 1e-6);
  scene.lighting.hard_shadows = true;
  const cv::Mat light = render(scene).pixels;
  EXPECT_NEAR(light.at<cv::Vec3f>(shadow_row, shadow_column)[1], 0.5 * 0.2, 1e-6);
  EXPECT_NEAR(light.at<cv::Vec3f>(shadow_row + 60, shadow_column)[1], lit, 1e-6);
}

TEST(Render, PointLightShinesFromItsPlace) {
  Scene scene = wall_scene();
  scene.lighting.at_infinity = false;
  scene.lighting.light_in_cam = {0, 0, 1};
  const cv::Mat light = render(scene).pixels;
  const auto cosine_at = [&](int x) {
    const double offset = 2 * (x - scene.camera.cx) / scene.camera.fx;
    const double down = 2 * (119 - scene.camera.cy) / scene.camera.fy;
    return 1 / std::sqrt(1 + offset * offset + down * down);
  };
  for (const int x : {20, 161, 300}) {
    EXPECT_NEAR(light.at<cv::Vec3f>(119, x)[1], 0.5 * (0.2 + 0.6 * cosine_at(x)), 1e-6);
  }
}

TEST(Render, CheckerHasItsMeanOnTheLineBetweenSquares) {
  Scene scene = wall_scene();
  scene.lighting = flat_light();
  scene.others[0].material.texture = {TextureKind::kChecker, {0.2, 0.2, 0.2}, {0.8, 0.8, 0.8}, 0.3, 0};
  const cv::Mat light = render(scene).pixels;
  // x = 0 lies at column 161.3: 0.8 of that pixel (160.5 to 161.5) is left of it.
  const float left = light.at<cv::Vec3f>(130, 150)[1];
  const float right = light.at<cv::Vec3f>(130, 170)[1];
  EXPECT_NEAR(std::abs(left - right), 0.6, 1e-6);
  EXPECT_NEAR(light.at<cv::Vec3f>(130, 161)[1], 0.8 * static_cast<double>(left) + 0.2 * static_cast<double>(right),
              0.02);
}

TEST(Render, HueOfColorsIsTheirs) {
  EXPECT_EQ(linear_from_hsv(0, 1, 1), LinearRgb(1, 0, 0));
  EXPECT_EQ(linear_from_hsv(60, 1, 1), LinearRgb(1, 1, 0));
  EXPECT_EQ(linear_from_hsv(240, 1, 1), LinearRgb(0, 0, 1));
  EXPECT_NEAR(linear_from_hsv(30, 1, 1).y(), 0.2140411, 1e-6);  // code 0.5
  EXPECT_NEAR(linear_from_hsv(200, 0, 0.5).x(), 0.2140411, 1e-6);
  EXPECT_EQ(linear_from_hsv(-10, 0.5, 0.5), linear_from_hsv(350, 0.5, 0.5));
}

TEST(Render, RefusesWhatCannotBe) {
  const Scene good = white_on_black(various_poses()[0]);
  EXPECT_THROW((void)render_coverage(good, 1), Error);
  Scene scene = good;
  scene.parts[0].cylinder.radius_m = 0;
  EXPECT_THROW((void)render(scene), Error);
  scene = good;
  scene.parts[0].cylinder.pose.axis_in_cam *= 2;
  EXPECT_THROW((void)render(scene), Error);
  scene = good;
  scene.parts[0].cylinder.pose.center_in_cam.x() = std::nan("");
  EXPECT_THROW((void)render(scene), Error);
  scene = good;
  scene.camera.fx = 0;
  EXPECT_THROW((void)render(scene), Error);
}

TEST(Render, NothingBehindTheCameraIsSeen) {
  const Scene scene = white_on_black({{0, 0, -1}, -Eigen::Vector3d::UnitY()});
  EXPECT_EQ(cv::sum(render_coverage(scene, 0))[0], 0);
}

}  // namespace
}  // namespace cylpose
