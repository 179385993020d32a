#include "agreement.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

namespace cylpose {
namespace {

constexpr int kReachPx = 2;

bool has_edge_near(const Mask& edges, const Eigen::Vector2d& pixel) {
  const int px = static_cast<int>(std::lround(pixel.x()));
  const int py = static_cast<int>(std::lround(pixel.y()));
  const Roi near = intersection({px - kReachPx, py - kReachPx, 2 * kReachPx + 1, 2 * kReachPx + 1}, edges.roi);
  for (int y = near.y; y < near.bottom(); ++y) {
    const std::size_t row = static_cast<std::size_t>(y - edges.roi.y) * static_cast<std::size_t>(edges.roi.width);
    for (int x = near.x; x < near.right(); ++x) {
      if (edges.pixels[row + static_cast<std::size_t>(x - edges.roi.x)] != 0) return true;
    }
  }
  return false;
}

}  // namespace

double thesis_rms_px(const CylinderPose& pose, double radius_m, const std::array<ThesisLine, 2>& sides,
                     double focal_px) {
  const auto planes = side_planes(pose, radius_m).value();
  double sum = 0;
  std::size_t count = 0;
  for (const ThesisLine& line : sides) {
    for (const Eigen::Vector2d& point : line.points) {
      const Eigen::Vector3d ray(point.x(), point.y(), focal_px);
      double nearest = std::numeric_limits<double>::infinity();
      for (const Eigen::Vector3d& normal : planes) {
        nearest = std::min(nearest, std::abs(normal.dot(ray)) / normal.head<2>().norm());
      }
      sum += nearest * nearest;
      ++count;
    }
  }
  return std::sqrt(sum / static_cast<double>(count));
}

double thesis_seen(const CylinderPose& pose, const PartModel& part, const CameraModel& camera, const Mask& edge_image) {
  const std::vector<Eigen::Vector2d> outline = silhouette(pose, part.radius_m, part.height_m);
  const auto pixel_of = [&](const Eigen::Vector2d& ray) { return project(camera, ray.homogeneous()); };
  int inside = 0;
  int seen = 0;
  for (std::size_t i = 0; i < outline.size(); ++i) {
    const Eigen::Vector2d& from = outline[i];
    const Eigen::Vector2d& to = outline[(i + 1) % outline.size()];
    // A sample a pixel; an outline that reaches close to the camera's plane is long, but not worth more than this.
    const double length_px = std::min((pixel_of(to) - pixel_of(from)).norm(), 1e4);
    const int samples = 1 + static_cast<int>(length_px);
    for (int k = 0; k < samples; ++k) {
      const Eigen::Vector2d pixel = pixel_of(from + (to - from) * (static_cast<double>(k) / samples));
      const bool in_image =
          pixel.x() >= 0 && pixel.y() >= 0 && pixel.x() <= camera.width - 1 && pixel.y() <= camera.height - 1;
      if (!in_image) continue;
      ++inside;
      if (has_edge_near(edge_image, pixel)) ++seen;
    }
  }
  return inside > 0 ? static_cast<double>(seen) / inside : 0;
}

}  // namespace cylpose
