#include <gmock/gmock.h>

#include <Eigen/Geometry>
#include <cylpose/cylinder.hpp>
#include <cylpose/debug_pictures.hpp>
#include <cylpose/error.hpp>
#include <cylpose/overlay.hpp>
#include <opencv2/imgproc.hpp>

namespace cylpose {
namespace {

struct Scene {
  CameraModel camera;
  PartModel part{"candle", 0.05, 0.4, 345, 15, 0.3, 0.2};
  PoseEstimate estimate;
  cv::Mat image;
};

Scene scene_of(int width, int height, DistortionModel model = DistortionModel::kNone,
               std::vector<double> distortion = {}) {
  Scene scene;
  const double f = width;
  scene.camera = {width, height, f, f, width / 2.0, height / 2.0, model, std::move(distortion), Transfer::kSrgb};
  scene.estimate.status = PoseStatus::kOk;
  scene.estimate.pose = with_fixed_sign({{0.15, 0.05, 1.2}, Eigen::Vector3d(0.3, -1, 0.4).normalized()});
  scene.estimate.covariance.setIdentity();
  const auto planes = side_planes(scene.estimate.pose, scene.part.radius_m);
  for (std::size_t i = 0; i < 2; ++i) {
    // The side's image line in pixels: n . K^-1 x = 0.
    const Eigen::Vector3d& n = (*planes)[i];
    const Eigen::Vector2d normal(n.x() / f, n.y() / f);
    const double constant = n.z() - n.x() * scene.camera.cx / f - n.y() * scene.camera.cy / f;
    scene.estimate.sides[i] = {normal.normalized(), -constant / normal.norm()};
  }
  scene.image = cv::Mat(height, width, CV_8UC3, cv::Scalar(90, 90, 90));
  return scene;
}

FrameEstimate frame_of(const Scene& scene) {
  return {{0, 0, scene.image.cols, scene.image.rows}, {scene.estimate}, {}};
}

cv::Mat overlay_of(const Scene& scene) {
  return overlay(scene.image, scene.camera, {&scene.part, 1}, frame_of(scene));
}

bool changed(const Scene& scene, const cv::Mat& picture, const Eigen::Vector2d& pixel) {
  const cv::Point p(static_cast<int>(std::lround(pixel.x())), static_cast<int>(std::lround(pixel.y())));
  return picture.at<cv::Vec3b>(p) != scene.image.at<cv::Vec3b>(p);
}

/// The share of the outline's pixels inside the image that the overlay changed, and how many there are.
std::pair<double, int> outline_share(const Scene& scene, const cv::Mat& picture) {
  int inside = 0;
  int hit = 0;
  for (const Eigen::Vector2d& ray : silhouette(scene.estimate.pose, scene.part.radius_m, scene.part.height_m, 200)) {
    const Eigen::Vector2d pixel = project(scene.camera, {ray.x(), ray.y(), 1});
    if (pixel.x() < 1 || pixel.y() < 1 || pixel.x() > scene.image.cols - 2 || pixel.y() > scene.image.rows - 2)
      continue;
    ++inside;
    hit += changed(scene, picture, pixel) ? 1 : 0;
  }
  return {static_cast<double>(hit) / std::max(1, inside), inside};
}

TEST(Overlay, DrawsAlongTheProjectedOutlineAtEverySize) {
  for (const cv::Size size : {cv::Size(640, 400), cv::Size(1280, 720), cv::Size(3840, 2160)}) {
    const Scene scene = scene_of(size.width, size.height);
    const cv::Mat picture = overlay_of(scene);
    ASSERT_EQ(picture.size(), size);
    ASSERT_EQ(picture.type(), CV_8UC3);
    const auto [share, inside] = outline_share(scene, picture);
    EXPECT_EQ(inside, 400);
    EXPECT_GT(share, 0.99) << size;
    EXPECT_TRUE(changed(scene, picture, project(scene.camera, scene.estimate.pose.center_in_cam)));
  }
}

TEST(Overlay, FollowsTheLensDistortion) {
  for (const Scene& scene : {scene_of(1280, 720, DistortionModel::kPlumbBob, {-0.3, 0.1, 0.002, -0.003, 0}),
                             scene_of(1280, 720, DistortionModel::kFisheye, {-0.02, 0.01, 0, 0})}) {
    const auto [share, inside] = outline_share(scene, overlay_of(scene));
    EXPECT_EQ(inside, 400);
    EXPECT_GT(share, 0.99);
  }
}

TEST(Overlay, ShowsTheMeasuredSidesEvenWhereTheyDisagreeWithThePose) {
  Scene scene = scene_of(1280, 720);
  scene.estimate.sides[0] = {{1, 0}, 100};
  const cv::Mat picture = overlay_of(scene);
  const Eigen::Vector2d center = project(scene.camera, scene.estimate.pose.center_in_cam);
  EXPECT_TRUE(changed(scene, picture, {100, center.y()}));
  EXPECT_FALSE(changed(scene, picture, {130, center.y()}));
}

TEST(Overlay, DrawsNoSidesWhereNoneAreSeen) {
  Scene scene = scene_of(640, 400);
  const auto magenta = [&] {
    cv::Mat side_pixels;
    cv::inRange(overlay_of(scene), cv::Scalar(200, 0, 200), cv::Scalar(255, 60, 255), side_pixels);
    return cv::countNonZero(side_pixels);
  };
  EXPECT_GT(magenta(), 100);
  scene.estimate.sides.fill({Eigen::Vector2d::Zero(), 0});
  EXPECT_EQ(magenta(), 0);
}

TEST(Overlay, DrawsThickerOnLargerPictures) {
  const auto share_drawn_on = [](int width, int height) {
    const Scene scene = scene_of(width, height);
    cv::Mat difference;
    cv::absdiff(overlay_of(scene), scene.image, difference);
    cv::cvtColor(difference, difference, cv::COLOR_BGR2GRAY);
    // Share of the picture that is drawn on: about constant when lines grow with the picture.
    return cv::countNonZero(difference) / static_cast<double>(difference.total());
  };
  const double small = share_drawn_on(640, 360);
  const double large = share_drawn_on(3840, 2160);
  EXPECT_GT(large, 0.4 * small);  // one pixel at every size would give 0.17
  EXPECT_LT(large, 2 * small);
}

TEST(Overlay, ShowsTheSearchRegionAndTheReasonWhereThereIsNoPose) {
  Scene scene = scene_of(640, 400);
  scene.estimate = {};
  scene.estimate.reason =
      "no two edges can be the sides of this cylinder, and a reason may well be longer than one line";
  FrameEstimate frame = frame_of(scene);
  frame.searched = {200, 150, 300, 200};
  const cv::Mat picture = overlay(scene.image, scene.camera, {&scene.part, 1}, frame);
  int edge = 0;
  for (int x = 200; x < 500; ++x) edge += changed(scene, picture, {x, 349}) ? 1 : 0;
  EXPECT_GT(edge, 100);
  EXPECT_FALSE(changed(scene, picture, {350, 250})) << "no cylinder is drawn";
  cv::Mat text_rows;
  cv::absdiff(picture.rowRange(0, 60), scene.image.rowRange(0, 60), text_rows);
  EXPECT_GT(cv::countNonZero(text_rows.reshape(1)), 1000);
  cv::absdiff(picture.col(639), scene.image.col(639), text_rows);
  EXPECT_EQ(cv::countNonZero(text_rows.reshape(1)), 0) << "text is broken before the picture ends";
}

TEST(Overlay, SurvivesPosesThatCannotBeDrawn) {
  Scene scene = scene_of(640, 400);
  scene.image = cv::Mat(400, 640, CV_8UC1, cv::Scalar(90));
  scene.estimate.pose.center_in_cam = {0, 0, 0.1};  // reaches behind the camera
  EXPECT_EQ(overlay_of(scene).type(), CV_8UC3);
  scene.estimate.pose = {{0, 0, 0.5}, {0, 0, 1}};  // looks along the axis
  EXPECT_EQ(overlay_of(scene).type(), CV_8UC3);
  scene.estimate.pose = {{50, 0, 0.3}, {0, -1, 0}};  // far outside
  EXPECT_EQ(overlay_of(scene).type(), CV_8UC3);
  FrameEstimate none;
  EXPECT_THROW((void)overlay(scene.image, scene.camera, {&scene.part, 1}, none), Error);
}

TEST(DebugPictures, OnePicturePerStageNamedByPart) {
  const Scene scene = scene_of(640, 400);
  StageTrace trace;
  trace.parts.resize(1);
  PartTrace& stages = trace.parts[0];
  stages.mask = {{10, 20, 4, 2}, {255, 0, 0, 255, 0, 0, 0, 0}};
  stages.edges = {{100, 200}};
  stages.chains = {{{110, 200}}, {{120, 200}}};
  stages.segments = {{{130, 200}}};
  stages.lines = {{{1, 0}, 300}};
  const std::vector<DebugPicture> pictures =
      debug_pictures(scene.image, scene.camera, {&scene.part, 1}, frame_of(scene), trace);
  std::vector<std::string> names;
  for (const DebugPicture& picture : pictures) {
    names.push_back(picture.name);
    EXPECT_EQ(picture.picture.size(), scene.image.size());
    EXPECT_EQ(picture.picture.type(), CV_8UC3);
  }
  ASSERT_THAT(names, testing::ElementsAre("candle_0_input", "candle_1_mask", "candle_2_edges", "candle_3_chains",
                                          "candle_4_segments", "candle_5_lines", "candle_6_pose"));
  const auto at = [&](std::size_t picture, int x, int y) { return pictures[picture].picture.at<cv::Vec3b>(y, x); };
  const cv::Vec3b white(255, 255, 255);
  const cv::Vec3b background = at(1, 11, 20);
  EXPECT_EQ(at(1, 10, 20), white);
  EXPECT_EQ(at(1, 13, 20), white);
  EXPECT_NE(background, white);
  EXPECT_NE(at(2, 100, 200), background);
  EXPECT_EQ(at(2, 101, 200), background);
  EXPECT_NE(at(3, 110, 200), background);
  EXPECT_NE(at(3, 120, 200), background);
  EXPECT_NE(at(3, 110, 200), at(3, 120, 200)) << "chains differ in colour";
  EXPECT_NE(at(4, 130, 200), background);
  EXPECT_NE(at(5, 300, 10), background);
  EXPECT_NE(at(5, 300, 390), background);
  EXPECT_EQ(at(5, 310, 200), background);
  EXPECT_EQ(cv::norm(pictures[6].picture, overlay_of(scene)), 0);
}

TEST(DebugPictures, LinesBendWithTheLensAndDoNotComeBack) {
  const Scene scene = scene_of(1280, 720, DistortionModel::kPlumbBob, {-0.3, 0.02, 0, 0, 0});
  StageTrace trace;
  trace.parts.resize(1);
  trace.parts[0].lines = {{{0, 1}, 700}};  // along the lower border, where the image of a straight line bulges
  const cv::Mat picture =
      debug_pictures(scene.image, scene.camera, {&scene.part, 1}, frame_of(scene), trace)[5].picture;
  const cv::Mat drawn = picture != picture.at<cv::Vec3b>(10, 10);
  for (const double u : {-0.4, -0.1, 0.0, 0.3}) {
    const double v = (700 - scene.camera.cy) / scene.camera.fy;
    const Eigen::Vector2d pixel = project(scene.camera, {u, v, 1});
    EXPECT_NE(drawn.at<cv::Vec3b>(static_cast<int>(std::lround(pixel.y())), static_cast<int>(std::lround(pixel.x()))),
              cv::Vec3b(0, 0, 0));
  }
  EXPECT_EQ(cv::countNonZero(drawn.rowRange(0, 500).clone().reshape(1)), 0) << "nothing in the upper part";
}

TEST(DebugPictures, RefusesATraceOfOtherParts) {
  const Scene scene = scene_of(640, 400);
  EXPECT_THROW((void)debug_pictures(scene.image, scene.camera, {&scene.part, 1}, frame_of(scene), {}), Error);
}

}  // namespace
}  // namespace cylpose
