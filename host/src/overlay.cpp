#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cylpose/cylinder.hpp>
#include <cylpose/error.hpp>
#include <cylpose/overlay.hpp>
#include <limits>
#include <numbers>
#include <utility>
#include <vector>

#include "canvas.hpp"
#include "draw.hpp"

namespace cylpose {
namespace {

const cv::Scalar kSideColor(255, 0, 255);
const cv::Scalar kOutlineColor(0, 255, 255);
const cv::Scalar kAxisColor(255, 255, 0);
const cv::Scalar kTextColor(255, 255, 255);
const cv::Scalar kNoneColor(80, 160, 255);

constexpr int kSamplesPerCircle = 96;
constexpr int kSamplesPerLine = 24;

/// Draws one part's pose.
class PoseDrawing {
 public:
  PoseDrawing(Canvas* canvas, const CameraModel& camera, const PartModel& part, const PoseEstimate& estimate)
      : canvas_(canvas), camera_(camera), part_(part), estimate_(estimate) {}

  void draw() {
    // Empty when part of the cylinder is behind the camera, where there is nothing to project.
    const std::vector<Eigen::Vector2d> outline = silhouette(estimate_.pose, part_.radius_m, part_.height_m);
    if (outline.empty()) return;
    for (const ImageLine& side : estimate_.sides) {
      if (!side.normal.isZero()) draw_side(side, outline);
    }
    if (const auto planes = side_planes(estimate_.pose, part_.radius_m)) {
      for (const Eigen::Vector3d& normal : *planes) draw_generator(-part_.radius_m * normal);
    }
    for (const double outward : {-1.0, 1.0}) draw_rim(outward);
    constexpr double kOverhang = 0.6;  // half heights beyond the centre: a little more than the cylinder
    canvas_->line(curve(at(-kOverhang), at(kOverhang)), kAxisColor, 1, LineStyle::kDashed);
    canvas_->cross(project(camera_, estimate_.pose.center_in_cam), kAxisColor);
  }

 private:
  /// Point of the axis, in heights from the centre.
  [[nodiscard]] Eigen::Vector3d at(double heights) const {
    return estimate_.pose.center_in_cam + heights * part_.height_m * estimate_.pose.axis_in_cam;
  }

  /// The image of a straight line in space: a curve where the lens distorts. Points behind the camera are left out.
  [[nodiscard]] std::vector<Eigen::Vector2d> curve(const Eigen::Vector3d& from, const Eigen::Vector3d& to) const {
    std::vector<Eigen::Vector2d> pixels;
    for (int i = 0; i <= kSamplesPerLine; ++i) {
      const Eigen::Vector3d point = from + (to - from) * i / kSamplesPerLine;
      if (point.z() > 0) pixels.push_back(project(camera_, point));
    }
    return pixels;
  }

  /// The measured line along the cylinder and a bit further.
  void draw_side(const ImageLine& side, const std::vector<Eigen::Vector2d>& outline) {
    const Eigen::Vector2d along(-side.normal.y(), side.normal.x());
    double first = std::numeric_limits<double>::infinity();
    double last = -first;
    for (const Eigen::Vector2d& ray : outline) {
      const double place = along.dot(ideal_pixel(camera_, {ray.x(), ray.y(), 1}));
      first = std::min(first, place);
      last = std::max(last, place);
    }
    const double overhang = 0.15 * (last - first);
    const auto ray_at = [&](double place) { return ideal_ray(camera_, side.distance * side.normal + place * along); };
    canvas_->line(curve(ray_at(first - overhang), ray_at(last + overhang)), kSideColor, 1, LineStyle::kSolid);
  }

  void draw_generator(const Eigen::Vector3d& from_axis) {
    canvas_->line(curve(at(-0.5) + from_axis, at(0.5) + from_axis), kOutlineColor, 1, LineStyle::kSolid);
  }

  /// A base's circle, its visible part solid. A base that faces the camera shows all of its rim, the other one what
  /// lies on the camera's side of the cylinder.
  void draw_rim(double outward) {
    const Eigen::Vector3d& axis = estimate_.pose.axis_in_cam;
    const Eigen::Vector3d center = at(outward / 2);
    const bool faces_camera = outward * axis.dot(center) < 0;
    const Eigen::Vector3d e1 = axis.unitOrthogonal();
    const Eigen::Vector3d e2 = axis.cross(e1);
    for (const bool visible : {false, true}) {
      std::vector<Eigen::Vector2d> run;
      const auto finish_run = [&] {
        canvas_->line(run, kOutlineColor, 1, visible ? LineStyle::kSolid : LineStyle::kDashed);
        run.clear();
      };
      for (int i = 0; i <= kSamplesPerCircle; ++i) {
        const double angle = 2 * std::numbers::pi * i / kSamplesPerCircle;
        const Eigen::Vector3d normal = std::cos(angle) * e1 + std::sin(angle) * e2;
        const Eigen::Vector3d point = center + part_.radius_m * normal;
        if ((faces_camera || normal.dot(point) < 0) == visible) {
          run.push_back(project(camera_, point));
        } else {
          finish_run();
        }
      }
      finish_run();
    }
  }

  Canvas* canvas_;
  const CameraModel& camera_;
  const PartModel& part_;
  const PoseEstimate& estimate_;
};

void write_numbers(Canvas* canvas, const PartModel& part, const PoseEstimate& estimate) {
  if (estimate.status == PoseStatus::kNone) {
    canvas->text(fmt::format("{}: none ({})", part.name, estimate.reason), kNoneColor);
    return;
  }
  constexpr double kMillimetres = 1000;
  const Eigen::Vector3d& c = estimate.pose.center_in_cam;
  const Eigen::Vector3d& a = estimate.pose.axis_in_cam;
  const Eigen::Vector3d sigma = kMillimetres * estimate.covariance.diagonal().head<3>().cwiseMax(0).cwiseSqrt();
  canvas->text(fmt::format("{}: {}, rms {:.2f} px, {} points", part.name, to_string(estimate.status), estimate.rms_px,
                           estimate.support),
               kTextColor);
  canvas->text(fmt::format("centre {:.4f} {:.4f} {:.4f} m, sigma {:.2f} {:.2f} {:.2f} mm", c.x(), c.y(), c.z(),
                           sigma.x(), sigma.y(), sigma.z()),
               kTextColor);
  canvas->text(fmt::format("axis {:.4f} {:.4f} {:.4f}, sigma {:.3f} deg", a.x(), a.y(), a.z(),
                           estimate.sigma_axis_rad() * 180 / std::numbers::pi),
               kTextColor);
}

}  // namespace

cv::Mat overlay(const cv::Mat& image, const CameraModel& camera, std::span<const PartModel> parts,
                const FrameEstimate& estimate) {
  if (parts.size() != estimate.parts.size()) {
    throw Error(ErrorKind::kInput,
                fmt::format("overlay: {} parts but {} estimates; give one each", parts.size(), estimate.parts.size()));
  }
  Canvas canvas(image);
  draw_search_region(&canvas, estimate.searched);
  for (std::size_t i = 0; i < parts.size(); ++i) {
    if (estimate.parts[i].status != PoseStatus::kNone) {
      PoseDrawing(&canvas, camera, parts[i], estimate.parts[i]).draw();
    }
  }
  // Text last, so that no line runs through it.
  for (std::size_t i = 0; i < parts.size(); ++i) write_numbers(&canvas, parts[i], estimate.parts[i]);
  return canvas.picture();
}

}  // namespace cylpose
