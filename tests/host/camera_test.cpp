#include <gmock/gmock.h>

#include <Eigen/Geometry>
#include <cmath>
#include <cylpose/camera.hpp>
#include <cylpose/error.hpp>
#include <limits>
#include <opencv2/calib3d.hpp>
#include <opencv2/core/persistence.hpp>

#include "temp_dir.hpp"

namespace cylpose {
namespace {

using testing::HasSubstr;

constexpr const char* kCameraInfo = R"(image_width: 640
image_height: 480
camera_name: narrow
camera_matrix:
  rows: 3
  cols: 3
  data: [500.5, 0, 320.25, 0, 501.5, 240.75, 0, 0, 1]
distortion_model: plumb_bob
distortion_coefficients:
  rows: 1
  cols: 5
  data: [-0.2, 0.05, 0.001, -0.002, 0.01]
rectification_matrix: {rows: 3, cols: 3, data: [1, 0, 0, 0, 1, 0, 0, 0, 1]}
)";

CameraModel wide_camera(DistortionModel model, std::vector<double> distortion) {
  CameraModel camera{1280, 720, 900, 910, 630, 370, model, std::move(distortion), Transfer::kSrgb};
  std::string why;
  EXPECT_TRUE(camera.is_valid(&why)) << why;
  return camera;
}

class CameraFile : public testing::Test {
 protected:
  /// The message with which the text is refused; fails when it is not.
  std::string refusal(const std::string& text) {
    try {
      (void)load_camera(folder_.write("camera.yaml", text));
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::kInput);
      EXPECT_THAT(error.what(), HasSubstr("camera.yaml"));
      return error.what();
    }
    ADD_FAILURE() << "was accepted:\n" << text;
    return {};
  }

  /// kCameraInfo with `from` replaced by `to`.
  static std::string changed(const std::string& from, const std::string& to) {
    std::string text = kCameraInfo;
    const std::size_t at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    return text.replace(at, from.size(), to);
  }

  TempDir folder_;
};

TEST_F(CameraFile, ReadsCameraInfo) {
  const CameraModel camera = load_camera(folder_.write("camera.yaml", kCameraInfo));
  EXPECT_EQ(camera.width, 640);
  EXPECT_EQ(camera.height, 480);
  EXPECT_EQ(camera.fx, 500.5);
  EXPECT_EQ(camera.fy, 501.5);
  EXPECT_EQ(camera.cx, 320.25);
  EXPECT_EQ(camera.cy, 240.75);
  EXPECT_EQ(camera.distortion_model, DistortionModel::kPlumbBob);
  EXPECT_EQ(camera.distortion, (std::vector<double>{-0.2, 0.05, 0.001, -0.002, 0.01}));
  EXPECT_EQ(camera.transfer, Transfer::kSrgb);
}

TEST_F(CameraFile, ReadsWhatOpenCvWrites) {
  const std::filesystem::path path = folder_.path() / "opencv.yml";
  {
    cv::FileStorage file(path.string(), cv::FileStorage::WRITE);
    file << "image_width" << 640 << "image_height" << 480;
    file << "camera_matrix" << cv::Mat(cv::Matx33d(500, 0, 320, 0, 501, 240, 0, 0, 1));
    file << "distortion_coefficients" << (cv::Mat_<double>(5, 1) << -0.2, 0.05, 0.001, -0.002, 0.01);
  }
  ASSERT_THAT(text_of(path), HasSubstr("%YAML:1.0"));
  ASSERT_THAT(text_of(path), HasSubstr("!!opencv-matrix"));
  const CameraModel camera = load_camera(path);
  EXPECT_EQ(camera.fy, 501);
  EXPECT_EQ(camera.distortion_model, DistortionModel::kPlumbBob);
  EXPECT_EQ(camera.distortion, (std::vector<double>{-0.2, 0.05, 0.001, -0.002, 0.01}));
}

TEST_F(CameraFile, ReadsOpenCvFisheyeAndPaddedRational) {
  const std::string head =
      "%YAML:1.0\n---\nimage_width: 64\nimage_height: 48\ncamera_matrix: !!opencv-matrix\n"
      "   rows: 3\n   cols: 3\n   dt: d\n   data: [ 50., 0., 32., 0., 50., 24., 0., 0., 1. ]\n";
  const CameraModel fisheye = load_camera(
      folder_.write("f.yml", head + "fisheye_model: 1\ndistortion_coefficients: !!opencv-matrix\n   rows: 4\n"
                                    "   cols: 1\n   dt: d\n   data: [ 0., 0., 0., 0. ]\n"));
  EXPECT_EQ(fisheye.distortion_model, DistortionModel::kFisheye) << "four zeros are still a fisheye";
  const CameraModel rational = load_camera(folder_.write(
      "r.yml",
      head + "distortion_coefficients: {rows: 1, cols: 14, data: [1, 2, 3, 4, 5, 6, 7, 8, 0, 0, 0, 0, 0, 0]}\n"));
  EXPECT_EQ(rational.distortion_model, DistortionModel::kRational);
  EXPECT_EQ(rational.distortion.size(), 8U);
}

TEST_F(CameraFile, ZeroCoefficientsAreNoDistortion) {
  const CameraModel camera =
      load_camera(folder_.write("camera.yaml", changed("-0.2, 0.05, 0.001, -0.002, 0.01", "0, 0, 0, 0, 0.0")));
  EXPECT_EQ(camera.distortion_model, DistortionModel::kNone);
  EXPECT_TRUE(camera.distortion.empty());
}

TEST_F(CameraFile, WhatIsSavedLoadsTheSame) {
  for (CameraModel camera : {wide_camera(DistortionModel::kNone, {}),
                             wide_camera(DistortionModel::kPlumbBob, {-0.1, 1.0 / 3, 0.001, 1e-9, 0.2}),
                             wide_camera(DistortionModel::kRational, {1, 2, 3, 4, 5, 6, 7, 8}),
                             wide_camera(DistortionModel::kFisheye, {0.1, 0.2, -0.3, 0.4})}) {
    camera.transfer = Transfer::kLinear;
    camera.fx = 1000.0 / 3;
    const std::filesystem::path path = folder_.path() / "saved.yaml";
    save_camera(camera, path);
    const CameraModel loaded = load_camera(path);
    EXPECT_EQ(loaded.width, camera.width);
    EXPECT_EQ(loaded.height, camera.height);
    EXPECT_EQ(loaded.fx, camera.fx);
    EXPECT_EQ(loaded.fy, camera.fy);
    EXPECT_EQ(loaded.cx, camera.cx);
    EXPECT_EQ(loaded.cy, camera.cy);
    EXPECT_EQ(loaded.distortion_model, camera.distortion_model);
    EXPECT_EQ(loaded.distortion, camera.distortion);
    EXPECT_EQ(loaded.transfer, Transfer::kLinear);
  }
}

TEST_F(CameraFile, SavingWhereNothingCanBeWrittenNamesThePath) {
  try {
    save_camera(wide_camera(DistortionModel::kNone, {}), folder_.path() / "missing" / "camera.yaml");
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::kOutput);
    EXPECT_THAT(error.what(), HasSubstr("missing/camera.yaml"));
  }
}

TEST_F(CameraFile, RefusesAnUncalibratedCamera) {
  EXPECT_THAT(refusal(changed("[500.5, 0,", "[0, 0,")), HasSubstr("uncalibrated; calibrate the camera"));
  EXPECT_THAT(refusal(changed("[500.5, 0,", "[-3, 0,")), HasSubstr("negative"));
}

TEST_F(CameraFile, RefusesNestingBeyondReason) {
  // Deep enough that a parser that calls itself per level without counting would run out of stack.
  for (const std::string level : {"[", "{a: ", "- ", "? ", "[\n"}) {
    std::string nested = "image_width: 640\nextra:\n ";
    for (int i = 0; i < 100'000; ++i) nested += level;
    EXPECT_THAT(refusal(nested), HasSubstr("no valid YAML")) << level;
  }
}

TEST_F(CameraFile, RefusalsNameLineKeyAndValue) {
  EXPECT_THAT(refusal(changed("image_width: 640", "image_width: wide")),
              HasSubstr("camera.yaml:1: image_width: 'wide' is no whole number"));
  for (const char* beyond_int : {"2147483648", "-9223372036854775808", "9223372036854775808"}) {
    EXPECT_THAT(refusal(changed("image_width: 640", std::string("image_width: ") + beyond_int)),
                HasSubstr("is no whole number"));
  }
  EXPECT_THAT(refusal(changed("image_width: 640\n", "")), HasSubstr("the key 'image_width' is missing"));
  EXPECT_THAT(refusal(changed("640", "-640")), HasSubstr("-640 x 480"));
  EXPECT_THAT(refusal(changed("640", "99999999999999")), HasSubstr("99999999999999"));
  EXPECT_THAT(refusal(changed("500.5", ".nan")), HasSubstr("camera.yaml:7: camera_matrix.data[0]: '.nan'"));
  EXPECT_THAT(refusal(changed("500.5", "nan")), HasSubstr("no finite number"));
  EXPECT_THAT(refusal(changed("500.5", "1e999")), HasSubstr("1e999"));
  EXPECT_THAT(refusal(changed("500.5, 0,", "500.5, 2,")), HasSubstr("[fx, 0, cx, 0, fy, cy, 0, 0, 1]"));
  EXPECT_THAT(refusal(changed("  data: [500.5, 0,", "  data: [0,")), HasSubstr("do not fit the 8 values"));
  EXPECT_THAT(refusal(changed("  rows: 3\n  cols: 3", "  rows: 9\n  cols: 1")), HasSubstr("is 9 x 1; expected 3 x 3"));
  EXPECT_THAT(refusal(changed("plumb_bob", "plum_bob")),
              HasSubstr("unknown lens model 'plum_bob'; known: none, plumb_bob, rational_polynomial"));
  EXPECT_THAT(refusal(changed("plumb_bob", "equidistant")),
              HasSubstr("has 5 coefficients; lens model equidistant takes 4"));
  EXPECT_THAT(refusal(changed("plumb_bob", "rational_polynomial")), HasSubstr("takes 8"));
  EXPECT_THAT(refusal(std::string(kCameraInfo) + "transfer: gamma\n"), HasSubstr("'gamma'; write srgb or linear"));
}

TEST_F(CameraFile, RefusesWhatIsNoCalibration) {
  EXPECT_THAT(refusal(""), HasSubstr("is empty"));
  EXPECT_THAT(refusal("\n  \n"), HasSubstr("is empty"));
  EXPECT_THAT(refusal("just words"), HasSubstr("expected `key: value`"));
  EXPECT_THAT(refusal("image_width: [640\nimage_height"), HasSubstr("no valid YAML"));
  EXPECT_THAT(refusal(std::string(kCameraInfo).substr(0, 180)), HasSubstr("camera.yaml"));
  EXPECT_THAT(refusal(std::string(2 << 20, 'x')), HasSubstr("is it the right file?"));
  EXPECT_THROW((void)load_camera(folder_.path()), Error);
  EXPECT_THROW((void)load_camera(folder_.path() / "none.yaml"), Error);
}

TEST(Camera, RefusesWhatNoCalibrationGives) {
  std::string why;
  EXPECT_FALSE(CameraModel{}.is_valid(&why));
  CameraModel camera = wide_camera(DistortionModel::kNone, {});
  camera.cy = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(camera.is_valid(&why));
  EXPECT_THAT(why, HasSubstr("cy is nan"));
  camera = wide_camera(DistortionModel::kNone, {});
  camera.distortion = {0.1, 0.2, 0, 0};
  EXPECT_FALSE(camera.is_valid(nullptr));
  camera.distortion_model = DistortionModel::kPlumbBob;
  EXPECT_TRUE(camera.is_valid(nullptr));
  camera.distortion[1] = std::numeric_limits<double>::infinity();
  EXPECT_FALSE(camera.is_valid(nullptr));
}

TEST(Camera, ProjectsAsOpenCvDoes) {
  const std::vector<cv::Point3d> points = {{0, 0, 2}, {0.4, -0.3, 1.5}, {-1, 0.5, 2}, {0.1, 0.9, 3}};
  const cv::Vec3d zero(0, 0, 0);
  for (const CameraModel& camera :
       {wide_camera(DistortionModel::kPlumbBob, {-0.2, 0.05, 0.001, -0.002}),
        wide_camera(DistortionModel::kPlumbBob, {-0.2, 0.05, 0.001, -0.002, 0.01}),
        wide_camera(DistortionModel::kRational, {0.3, -0.1, 0.001, -0.002, 0.02, 0.6, -0.05, 0.01}),
        wide_camera(DistortionModel::kFisheye, {-0.02, 0.01, -0.003, 0.001})}) {
    const cv::Matx33d k(camera.fx, 0, camera.cx, 0, camera.fy, camera.cy, 0, 0, 1);
    std::vector<cv::Point2d> expected;
    if (camera.distortion_model == DistortionModel::kFisheye) {
      cv::fisheye::projectPoints(points, expected, zero, zero, k, camera.distortion);
    } else {
      cv::projectPoints(points, zero, zero, k, camera.distortion, expected);
    }
    for (std::size_t i = 0; i < points.size(); ++i) {
      const Eigen::Vector2d pixel = project(camera, {points[i].x, points[i].y, points[i].z});
      EXPECT_NEAR(pixel.x(), expected[i].x, 1e-9);
      EXPECT_NEAR(pixel.y(), expected[i].y, 1e-9);
    }
  }
}

TEST(Camera, UndistortedIsTheInverseOfProjectOverTheWholeImage) {
  for (const CameraModel& camera :
       {wide_camera(DistortionModel::kNone, {}),
        wide_camera(DistortionModel::kPlumbBob, {-0.2, 0.05, 0.001, -0.002, 0}),
        wide_camera(DistortionModel::kRational, {0.3, -0.1, 0.001, -0.002, 0.02, 0.6, -0.05, 0.01}),
        wide_camera(DistortionModel::kFisheye, {-0.02, 0.01, -0.003, 0.001})}) {
    std::vector<Eigen::Vector2d> pixels;
    for (int y = 0; y < camera.height; y += 40) {
      for (int x = 0; x < camera.width; x += 40) pixels.emplace_back(x, y);
    }
    const std::vector<Eigen::Vector2d> rays = undistorted(camera, pixels);
    ASSERT_EQ(rays.size(), pixels.size());
    for (std::size_t i = 0; i < rays.size(); ++i) {
      EXPECT_LT((project(camera, rays[i].homogeneous()) - pixels[i]).norm(), 1e-6) << pixels[i].transpose();
    }
  }
}

TEST(Camera, ThePrincipalPointLooksStraightAhead) {
  const CameraModel camera = wide_camera(DistortionModel::kFisheye, {-0.02, 0.01, -0.003, 0.001});
  EXPECT_EQ(project(camera, {0, 0, 3}), Eigen::Vector2d(630, 370));
  const Eigen::Vector2d pixel(630, 370);
  EXPECT_LT(undistorted(camera, {&pixel, 1})[0].norm(), 1e-12);
  EXPECT_TRUE(undistorted(camera, {}).empty());
}

}  // namespace
}  // namespace cylpose
