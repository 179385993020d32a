#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cylpose/debug_pictures.hpp>
#include <cylpose/error.hpp>
#include <cylpose/overlay.hpp>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "canvas.hpp"
#include "draw.hpp"

namespace cylpose {
namespace {

const cv::Scalar kEdgeColor(0, 255, 255);

using Points = std::vector<Eigen::Vector2d>;

/// Colours that neighbours in a list do not share.
cv::Scalar color_of(std::size_t index) {
  const std::array<cv::Scalar, 8> colors = {
      cv::Scalar(80, 80, 255),  cv::Scalar(80, 255, 80),  cv::Scalar(255, 128, 80), cv::Scalar(80, 255, 255),
      cv::Scalar(255, 80, 255), cv::Scalar(255, 255, 80), cv::Scalar(80, 160, 255), cv::Scalar(255, 160, 220)};
  return colors[index % colors.size()];
}

/// The frame darkened, so that what the stages found stands out.
cv::Mat dimmed(const cv::Mat& image) {
  cv::Mat dark;
  image.convertTo(dark, -1, 0.35);
  return dark;
}

/// Pixel of the frame for a place in the ideal camera, in which traces are written.
Eigen::Vector2d frame_pixel(const CameraModel& camera, const Eigen::Vector2d& ideal) {
  return project(camera, ideal_ray(camera, ideal));
}

cv::Mat mask_picture(const cv::Mat& image, const Mask& mask) {
  Canvas canvas(dimmed(image));
  cv::Mat picture = canvas.picture();
  const cv::Rect inside =
      cv::Rect(mask.roi.x, mask.roi.y, mask.roi.width, mask.roi.height) & cv::Rect(0, 0, picture.cols, picture.rows);
  if (mask.pixels.empty() || inside.area() != mask.roi.width * mask.roi.height) return picture;
  const cv::Mat bytes(mask.roi.height, mask.roi.width, CV_8UC1, const_cast<std::uint8_t*>(mask.pixels.data()));
  picture(inside).setTo(cv::Scalar(255, 255, 255), bytes);
  return picture;
}

cv::Mat points_picture(const cv::Mat& image, const CameraModel& camera, const Points& points) {
  Canvas canvas(dimmed(image));
  for (const Eigen::Vector2d& point : points) canvas.dot(frame_pixel(camera, point), kEdgeColor);
  return canvas.picture();
}

cv::Mat runs_picture(const cv::Mat& image, const CameraModel& camera, const std::vector<Points>& runs) {
  Canvas canvas(dimmed(image));
  for (std::size_t i = 0; i < runs.size(); ++i) {
    for (const Eigen::Vector2d& point : runs[i]) canvas.dot(frame_pixel(camera, point), color_of(i));
  }
  return canvas.picture();
}

/// Distance in ideal pixels from `middle` beyond which nothing can be seen. Farther out the polynomials of a lens model
/// turn back, and a line drawn there would come into the picture again.
double seen_radius(const cv::Mat& image, const CameraModel& camera, const Eigen::Vector2d& middle) {
  const double right = image.cols - 1;
  const double bottom = image.rows - 1;
  const std::array<Eigen::Vector2d, 4> corners = {Eigen::Vector2d(0, 0), Eigen::Vector2d(right, 0),
                                                  Eigen::Vector2d(0, bottom), Eigen::Vector2d(right, bottom)};
  double radius = 0;
  for (const Eigen::Vector2d& ray : undistorted(camera, corners)) {
    radius = std::max(radius, (ideal_pixel(camera, {ray.x(), ray.y(), 1}) - middle).norm());
  }
  return std::min(radius, 4 * std::hypot(right, bottom));  // corners of a fisheye may look sideways
}

cv::Mat lines_picture(const cv::Mat& image, const CameraModel& camera, const std::vector<ImageLine>& lines) {
  constexpr int kSamples = 64;
  Canvas canvas(dimmed(image));
  const Eigen::Vector2d middle(image.cols / 2.0, image.rows / 2.0);
  const double radius = seen_radius(image, camera, middle);
  for (std::size_t i = 0; i < lines.size(); ++i) {
    // The chord of the seen circle, from the line's point nearest to the middle to both sides.
    const double off_middle = signed_distance(lines[i], middle);
    const double reach = std::sqrt(std::max(0.0, radius * radius - off_middle * off_middle));
    const Eigen::Vector2d foot = middle - off_middle * lines[i].normal;
    const Eigen::Vector2d along(-lines[i].normal.y(), lines[i].normal.x());
    Points curve;
    for (int k = -kSamples; k <= kSamples; ++k) {
      curve.push_back(frame_pixel(camera, foot + along * (reach * k / kSamples)));
    }
    canvas.line(curve, color_of(i), 1, LineStyle::kSolid);
  }
  return canvas.picture();
}

}  // namespace

std::vector<DebugPicture> debug_pictures(const cv::Mat& image, const CameraModel& camera,
                                         std::span<const PartModel> parts, const FrameEstimate& estimate,
                                         const StageTrace& trace) {
  if (parts.size() != estimate.parts.size() || parts.size() != trace.parts.size()) {
    throw Error(ErrorKind::kInput, fmt::format("debug pictures: {} parts but {} estimates and {} traces; give one each",
                                               parts.size(), estimate.parts.size(), trace.parts.size()));
  }
  std::vector<DebugPicture> pictures;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const PartTrace& stages = trace.parts[i];
    const auto add = [&](const char* stage, cv::Mat picture) {
      pictures.push_back({fmt::format("{}_{}", parts[i].name, stage), std::move(picture)});
    };
    Canvas input(image);
    draw_search_region(&input, estimate.searched);
    add("0_input", input.picture());
    add("1_mask", mask_picture(image, stages.mask));
    add("2_edges", points_picture(image, camera, stages.edges));
    add("3_chains", runs_picture(image, camera, stages.chains));
    add("4_segments", runs_picture(image, camera, stages.segments));
    add("5_lines", lines_picture(image, camera, stages.lines));
    FrameEstimate alone;
    alone.searched = estimate.searched;
    alone.parts = {estimate.parts[i]};
    add("6_pose", overlay(image, camera, parts.subspan(i, 1), alone));
  }
  return pictures;
}

}  // namespace cylpose
