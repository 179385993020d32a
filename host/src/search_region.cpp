#include <algorithm>
#include <cmath>
#include <cylpose/cylinder.hpp>
#include <cylpose/search_region.hpp>

namespace cylpose {

Roi outline_box(const CameraModel& camera, const PartModel& part, const CylinderPose& pose) {
  const std::vector<Eigen::Vector2d> rays = silhouette(pose, part.radius_m, part.height_m);
  if (rays.empty()) return {};
  const Eigen::Vector2d first = project(camera, {rays.front().x(), rays.front().y(), 1});
  Eigen::Array2d low = first;
  Eigen::Array2d high = first;
  for (const Eigen::Vector2d& ray : rays) {
    const Eigen::Array2d pixel = project(camera, {ray.x(), ray.y(), 1});
    low = low.min(pixel);
    high = high.max(pixel);
  }
  // Far outside the image the numbers may be too large for int: cut first.
  const Eigen::Array2d size(camera.width, camera.height);
  low = low.max(-size).floor();
  high = high.min(2 * size).ceil();
  const Roi box{static_cast<int>(low.x()), static_cast<int>(low.y()), static_cast<int>(high.x() - low.x()) + 1,
                static_cast<int>(high.y() - low.y()) + 1};
  return intersection(box, {0, 0, camera.width, camera.height});
}

void SearchRegion::update(std::span<const PartModel> parts, std::span<const PoseEstimate> estimates) {
  constexpr double kEnlargement = 0.25;
  Roi all;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const Roi box =
        estimates[i].status == PoseStatus::kNone ? Roi{} : outline_box(camera_, parts[i], estimates[i].pose);
    if (box.empty()) {
      next_ = whole();
      return;
    }
    all = united(all, box);
  }
  const Roi by_size = enlarged(all, kEnlargement, camera_.width, camera_.height);
  const Roi by_margin{all.x - kMinMarginPx, all.y - kMinMarginPx, all.width + 2 * kMinMarginPx,
                      all.height + 2 * kMinMarginPx};
  next_ = united(by_size, intersection(by_margin, whole()));
}

}  // namespace cylpose
