#include "random_place.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cylpose/cylinder.hpp>
#include <cylpose/error.hpp>
#include <opencv2/imgproc.hpp>
#include <string>
#include <vector>

#include "angle.hpp"

namespace cylpose::bench {
namespace {

constexpr double kMarginPx = 6;  // of the outline from the image's border

bool is_inside_image(const CameraModel& camera, const PartModel& part, const CylinderPose& pose) {
  const auto outline = silhouette(pose, part.radius_m, part.height_m);
  return !outline.empty() && std::all_of(outline.begin(), outline.end(), [&](const Eigen::Vector2d& ray) {
    const Eigen::Vector2d pixel = project(camera, {ray.x(), ray.y(), 1});
    return pixel.x() >= kMarginPx && pixel.x() <= camera.width - 1 - kMarginPx && pixel.y() >= kMarginPx &&
           pixel.y() <= camera.height - 1 - kMarginPx;
  });
}

}  // namespace

CylinderPose random_pose(const CameraModel& camera, const PartModel& part, double distance_m, double least_tilt_deg,
                         double most_tilt_deg, Dice* dice) {
  constexpr int kAttempts = 10000;
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    const Eigen::Vector2d pixel(dice->between(0, camera.width - 1), dice->between(0, camera.height - 1));
    const Eigen::Vector3d sight = ideal_ray(camera, pixel).normalized();
    const Eigen::Vector3d right = Eigen::Vector3d::UnitY().cross(sight).normalized();
    const double tilt = radians(dice->between(least_tilt_deg, most_tilt_deg));
    const double turn = radians(dice->between(0, 360));
    const Eigen::Vector3d beside = std::cos(turn) * right + std::sin(turn) * sight.cross(right);
    const double sign = dice->index(2) == 0 ? 1 : -1;  // which end is the nearer one
    CylinderPose pose{distance_m * sight, sign * std::cos(tilt) * sight + std::sin(tilt) * beside};
    if (is_inside_image(camera, part, pose)) return pose;
  }
  throw Error(ErrorKind::kInput, "a cylinder of " + std::to_string(part.height_m) + " m at " +
                                     std::to_string(distance_m) +
                                     " m finds no place in the image; put it farther away");
}

CameraModel cut_to_part(const CameraModel& camera, const PartModel& part, const CylinderPose& pose, int margin_px) {
  Eigen::Vector2d low(camera.width, camera.height);
  Eigen::Vector2d high(0, 0);
  for (const Eigen::Vector2d& ray : silhouette(pose, part.radius_m, part.height_m)) {
    const Eigen::Vector2d pixel = project(camera, {ray.x(), ray.y(), 1});
    low = low.cwiseMin(pixel);
    high = high.cwiseMax(pixel);
  }
  const int left = std::max(0, static_cast<int>(std::floor(low.x())) - margin_px);
  const int top = std::max(0, static_cast<int>(std::floor(low.y())) - margin_px);
  CameraModel cut = camera;
  cut.width = std::min(camera.width, static_cast<int>(std::ceil(high.x())) + margin_px + 1) - left;
  cut.height = std::min(camera.height, static_cast<int>(std::ceil(high.y())) + margin_px + 1) - top;
  cut.cx -= left;
  cut.cy -= top;
  return cut;
}

BoxSolid random_bar(const PartModel& part, const CylinderPose& pose, double share, Dice* dice) {
  const std::vector<Eigen::Vector2d> outline = silhouette(pose, part.radius_m, part.height_m);
  const Eigen::Vector3d& center = pose.center_in_cam;
  const Eigen::Vector3d& axis = pose.axis_in_cam;
  const Eigen::Vector2d image_of_axis = axis.head<2>() - center.head<2>() / center.z() * axis.z();
  const double turn = std::atan2(image_of_axis.y(), image_of_axis.x()) + radians(dice->between(-30, 30));
  const Eigen::Vector2d along(std::cos(turn), std::sin(turn));
  const Eigen::Vector2d across(-along.y(), along.x());
  double low = outline.front().dot(along);
  double high = low;
  double size = 0;
  for (const Eigen::Vector2d& ray : outline) {
    low = std::min(low, ray.dot(along));
    high = std::max(high, ray.dot(along));
    size = std::max(size, (ray - outline.front()).norm());
  }
  const double width = share * (high - low);
  const double start = dice->between(low, high - width);
  const Eigen::Vector2d middle = (start + width / 2) * along + center.head<2>().dot(across) / center.z() * across;

  constexpr double kHalfThicknessM = 0.005;
  const double depth = 0.7 * (center.z() - std::hypot(part.height_m / 2, part.radius_m));
  BoxSolid bar;
  bar.center_in_cam = depth * Eigen::Vector3d(middle.x(), middle.y(), 1);
  bar.cam_from_box.topLeftCorner<2, 2>() << along.x(), across.x(), along.y(), across.y();
  bar.half_size_m = {depth * width / 2, depth * 1.5 * size, kHalfThicknessM};
  return bar;
}

bool hides(const CameraModel& camera, const BoxSolid& box, const Eigen::Vector2d& position_px) {
  std::vector<cv::Point2f> corners;
  for (const double x : {-1.0, 1.0}) {
    for (const double y : {-1.0, 1.0}) {
      for (const double z : {-1.0, 1.0}) {
        const Eigen::Vector3d corner = box.half_size_m.cwiseProduct(Eigen::Vector3d(x, y, z));
        const Eigen::Vector2d pixel = ideal_pixel(camera, box.center_in_cam + box.cam_from_box * corner);
        corners.emplace_back(static_cast<float>(pixel.x()), static_cast<float>(pixel.y()));
      }
    }
  }
  std::vector<cv::Point2f> hull;
  cv::convexHull(corners, hull);
  const cv::Point2f place(static_cast<float>(position_px.x()), static_cast<float>(position_px.y()));
  return cv::pointPolygonTest(hull, place, false) >= 0;
}

}  // namespace cylpose::bench
