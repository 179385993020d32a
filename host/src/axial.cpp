#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cylpose/axial.hpp>

namespace cylpose {
namespace {

// Edge points whose normal is closer to the axis's image than this (cosine of 60 degrees) can belong to a base.
constexpr double kMinBaseNormalCosine = 0.5;
// Places along the axis that lie within this many pixels of each other agree.
constexpr double kAgreementPx = 3;
constexpr int kMinAgreeing = 4;

CylinderPose at(const AxisLine& axis, double place) {
  return {axis.point_in_cam + place * axis.direction_in_cam, axis.direction_in_cam};
}

// Where on the axis the ray comes nearest to it, in metres from the axis's point nearest to the camera.
double nearest_place(const AxisLine& axis, const Eigen::Vector3d& ray) {
  const Eigen::Vector3d& d = axis.direction_in_cam;
  const double along = ray.dot(d);
  return along * ray.dot(axis.point_in_cam) / (ray.squaredNorm() - along * along);
}

// Centre of mass of the outline's area, in pixels.
Eigen::Vector2d center_of_mass(const CameraModel& camera, const std::vector<Eigen::Vector2d>& outline) {
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  double twice_area = 0;
  const Eigen::Vector2d& origin = outline.front();
  for (std::size_t i = 1; i + 1 < outline.size(); ++i) {
    const Eigen::Vector2d a = outline[i] - origin;
    const Eigen::Vector2d b = outline[i + 1] - origin;
    const double twice = a.x() * b.y() - a.y() * b.x();
    sum += twice * (a + b) / 3;
    twice_area += twice;
  }
  const Eigen::Vector2d ray = twice_area != 0 ? Eigen::Vector2d(origin + sum / twice_area) : origin;
  return ideal_pixel(camera, {ray.x(), ray.y(), 1});
}

double place_from_region(const CameraModel& camera, const PartModel& part, const AxisLine& axis,
                         const RegionStatistics& region) {
  const Eigen::Vector2d mean(region.mean_x(), region.mean_y());
  double place = nearest_place(axis, ideal_ray(camera, mean));
  Eigen::Vector2d aim = mean;
  for (int step = 0; step < 3; ++step) {
    const auto outline = silhouette(at(axis, place), part.radius_m, part.height_m, 16);
    if (outline.empty()) break;
    aim += mean - center_of_mass(camera, outline);
    place = nearest_place(axis, ideal_ray(camera, aim));
  }
  return place;
}

struct Agreement {
  double place;
  int votes;
};

// The windows of `width` that hold most of the sorted places, not overlapping each other.
std::vector<Agreement> densest_windows(const std::vector<double>& places, double width, int max_windows) {
  std::vector<Agreement> windows;
  std::size_t last = 0;
  for (std::size_t first = 0; first < places.size(); ++first) {
    while (last < places.size() && places[last] - places[first] <= width) ++last;
    windows.push_back({places[first + (last - first) / 2], static_cast<int>(last - first)});
  }
  std::stable_sort(windows.begin(), windows.end(), [](const auto& a, const auto& b) { return a.votes > b.votes; });
  std::vector<Agreement> best;
  for (const Agreement& window : windows) {
    if (static_cast<int>(best.size()) == max_windows || window.votes < kMinAgreeing) break;
    const bool apart = std::all_of(best.begin(), best.end(), [&](const Agreement& other) {
      return std::abs(other.place - window.place) > 2 * width;
    });
    if (apart) best.push_back(window);
  }
  return best;
}

}  // namespace

std::optional<double> place_of_base(const AxisLine& axis, double radius_m, const Eigen::Vector3d& ray, bool upper) {
  const double along = ray.dot(axis.direction_in_cam);
  const Eigen::Vector3d across = ray - along * axis.direction_in_cam;
  const double a = across.squaredNorm();
  const double b = across.dot(axis.point_in_cam);
  const double discriminant = b * b - a * (axis.point_in_cam.squaredNorm() - radius_m * radius_m);
  if (discriminant <= 0 || b <= 0) return std::nullopt;
  const bool faces_camera = upper ? along < 0 : along > 0;
  const double t = (b + (faces_camera ? 1 : -1) * std::sqrt(discriminant)) / a;
  return t * along;
}

std::vector<CylinderPose> candidate_centers(const CameraModel& camera, const PartModel& part, const AxisLine& axis,
                                            std::span<const EdgePoint> points, const RegionStatistics& region,
                                            int max_candidates) {
  const double from_region = place_from_region(camera, part, axis, region);
  const CylinderPose middle = at(axis, from_region);
  if (middle.center_in_cam.z() <= 0) return {};
  const Eigen::Vector3d step = axis.direction_in_cam * (part.height_m / 100);
  const Eigen::Vector2d axis_image =
      ideal_pixel(camera, middle.center_in_cam + step) - ideal_pixel(camera, middle.center_in_cam - step);
  const double px_per_metre = axis_image.norm() / (2 * step.norm());
  const Eigen::Vector2d axis_direction = axis_image.normalized();

  std::vector<double> places;
  for (const EdgePoint& point : points) {
    const double cosine = point.inward.dot(axis_direction);
    if (std::abs(cosine) < kMinBaseNormalCosine) continue;
    const bool upper = cosine < 0;
    if (const auto base = place_of_base(axis, part.radius_m, ideal_ray(camera, point.position_px), upper)) {
      places.push_back(*base + (upper ? -part.height_m : part.height_m) / 2);
    }
  }
  std::sort(places.begin(), places.end());

  std::vector<CylinderPose> candidates;
  for (const Agreement& agreement : densest_windows(places, kAgreementPx / px_per_metre, max_candidates - 1)) {
    candidates.push_back(at(axis, agreement.place));
  }
  candidates.push_back(middle);
  return candidates;
}

}  // namespace cylpose
