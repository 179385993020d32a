// The calibrated camera. Camera optical frame: x right, y down, z forward, metres (ROS REP 103 "optical").
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

namespace cylpose {

/// Lens models as camera_info files name them. Coefficients in OpenCV's order.
enum class DistortionModel {
  kNone,      ///< "none", or all coefficients zero
  kPlumbBob,  ///< "plumb_bob": k1 k2 p1 p2 [k3]
  kRational,  ///< "rational_polynomial": k1 k2 p1 p2 k3 k4 k5 k6
  kFisheye,   ///< "equidistant" or "fisheye": k1 k2 k3 k4 (Kannala and Brandt 2006)
};

/// How the camera turns light into codes.
enum class Transfer {
  kSrgb,    ///< IEC 61966-2-1, what nearly all cameras and image files deliver
  kLinear,  ///< codes proportional to light
};

struct CameraModel {
  int width = 0;   ///< pixels, of the calibration and of every image
  int height = 0;  ///< pixels
  double fx = 0;   ///< focal length in pixels
  double fy = 0;
  double cx = 0;  ///< principal point in pixels; (0,0) is the centre of the top-left pixel
  double cy = 0;
  DistortionModel distortion_model = DistortionModel::kNone;
  std::vector<double> distortion;
  Transfer transfer = Transfer::kSrgb;

  /// False, with the reason in `why`, for sizes, focal lengths or coefficients that no calibration gives.
  [[nodiscard]] bool is_valid(std::string* why) const;
};

/// Reads a camera_info or OpenCV calibration YAML (design: keys image_width, image_height, camera_matrix,
/// distortion_coefficients, distortion_model; optional transfer: srgb | linear).
/// Throws Error(kInput) that names file, key and remedy; an uncalibrated camera (zero focal length) is refused.
[[nodiscard]] CameraModel load_camera(const std::filesystem::path& path);

/// Writes what load_camera reads. Throws Error(kOutput).
void save_camera(const CameraModel& camera, const std::filesystem::path& path);

/// Pixel of a point in front of the camera: x_pixel = K * distort(x/z, y/z). `point_in_cam` in metres, z > 0.
[[nodiscard]] Eigen::Vector2d project(const CameraModel& camera, const Eigen::Vector3d& point_in_cam);

/// The ideal camera is the camera without its distortion: same focal length and principal point. There straight lines
/// are straight. Ray (u, v, 1) of one of its pixels, and pixel of a point in metres with z > 0.
[[nodiscard]] inline Eigen::Vector3d ideal_ray(const CameraModel& camera, const Eigen::Vector2d& pixel) {
  return {(pixel.x() - camera.cx) / camera.fx, (pixel.y() - camera.cy) / camera.fy, 1};
}
[[nodiscard]] inline Eigen::Vector2d ideal_pixel(const CameraModel& camera, const Eigen::Vector3d& point_in_cam) {
  return {camera.fx * point_in_cam.x() / point_in_cam.z() + camera.cx,
          camera.fy * point_in_cam.y() / point_in_cam.z() + camera.cy};
}

/// Normalised, undistorted image coordinates (u, v) of pixels, so that the ray in the camera frame is (u, v, 1).
/// Points are undistorted, never images (cv::undistortPoints, cv::fisheye::undistortPoints).
[[nodiscard]] std::vector<Eigen::Vector2d> undistorted(const CameraModel& camera,
                                                       std::span<const Eigen::Vector2d> pixels);

}  // namespace cylpose
