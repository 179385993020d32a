// The pose of one cylinder in one image: what a program needs of cylpose::host, and no more.
//   one_image camera.yaml parts.yaml image.png
#include <cstdio>
#include <cylpose/camera.hpp>
#include <cylpose/error.hpp>
#include <cylpose/estimator.hpp>
#include <cylpose/image_cv.hpp>
#include <cylpose/part.hpp>
#include <opencv2/imgcodecs.hpp>

int main(int argc, char** argv) {
  if (argc != 4) {
    std::fprintf(stderr, "usage: %s camera.yaml parts.yaml image\n", argv[0]);
    return 2;
  }
  try {
    const cylpose::CameraModel camera = cylpose::load_camera(argv[1]);
    const auto estimator = cylpose::make_estimator("default", camera, cylpose::load_parts(argv[2]));
    const cv::Mat image = cv::imread(argv[3]);
    const cylpose::PoseEstimate part = estimator->estimate(cylpose::view_of(image)).parts.front();
    if (part.status != cylpose::PoseStatus::kOk) {
      std::printf("no pose: %s\n", part.reason.c_str());
      return 1;
    }
    const Eigen::Vector3d& center = part.pose.center_in_cam;
    const Eigen::Vector3d& axis = part.pose.axis_in_cam;
    std::printf("centre %.4f %.4f %.4f m, axis %.4f %.4f %.4f, %.2f px rms\n", center.x(), center.y(), center.z(),
                axis.x(), axis.y(), axis.z(), part.rms_px);
  } catch (const cylpose::Error& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
}
