// The thesis's method end to end, frame after frame.
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cylpose/error.hpp>
#include <cylpose/thesis.hpp>
#include <limits>
#include <utility>

#include "agreement.hpp"
#include "stage_clock.hpp"

namespace cylpose {
namespace {

PoseEstimate none(std::string reason) {
  PoseEstimate estimate;
  estimate.reason = std::move(reason);
  return estimate;
}

// A line and its points in a coordinate system whose origin lies at -offset.
ThesisLine shifted(ThesisLine line, const Eigen::Vector2d& offset) {
  line.delta_px += line.normal().dot(offset);
  for (Eigen::Vector2d& point : line.points) point += offset;
  return line;
}

ImageLine ideal_line(const ThesisLine& line) {
  return {line.normal(), line.delta_px};
}

// The line in frame pixels, through the images of both ends of its support: exact without distortion, else its chord.
ImageLine frame_line(const CameraModel& camera, const ThesisLine& line) {
  const Eigen::Vector2d normal = line.normal();
  const Eigen::Vector2d direction(-normal.y(), normal.x());
  double begin = std::numeric_limits<double>::infinity();
  double end = -begin;
  for (const Eigen::Vector2d& point : line.points) {
    begin = std::min(begin, direction.dot(point));
    end = std::max(end, direction.dot(point));
  }
  const auto pixel_at = [&](double along) {
    const Eigen::Vector2d ideal = line.delta_px * normal + along * direction;
    return project(camera, (ideal / thesis_focal_px(camera)).homogeneous());
  };
  const Eigen::Vector2d from = pixel_at(begin);
  const Eigen::Vector2d chord = (pixel_at(end) - from).normalized();
  const Eigen::Vector2d across(-chord.y(), chord.x());
  return {across, across.dot(from)};
}

std::vector<Eigen::Vector2d> pixels_of(const Mask& edges) {
  std::vector<Eigen::Vector2d> pixels;
  for (std::size_t i = 0; i < edges.pixels.size(); ++i) {
    if (edges.pixels[i] == 0) continue;
    const auto width = static_cast<std::size_t>(edges.roi.width);
    pixels.emplace_back(edges.roi.x + static_cast<int>(i % width), edges.roi.y + static_cast<int>(i / width));
  }
  return pixels;
}

class ThesisEstimator final : public Estimator {
 public:
  ThesisEstimator(CameraModel camera, std::vector<PartModel> parts, const ThesisOptions& options)
      : camera_(std::move(camera)), parts_(std::move(parts)), options_(options), last_boxes_(parts_.size()) {}

  [[nodiscard]] std::string_view name() const override { return "thesis"; }

  [[nodiscard]] FrameEstimate estimate(const ImageView& image, StageTrace* trace) override {
    require_usable(image);
    require_calibrated_size(camera_, image);
    FrameEstimate frame;
    StageClock clock;
    if (trace != nullptr) trace->parts.assign(parts_.size(), {});
    for (std::size_t i = 0; i < parts_.size(); ++i) {
      PartTrace* part_trace = trace != nullptr ? &trace->parts[i] : nullptr;
      RegionStatistics region;
      Roi search = last_boxes_[i].empty() ? image.bounds()
                                          : enlarged(last_boxes_[i], options_.search_growth, image.width, image.height);
      PoseEstimate estimate = estimate_part(image, search, parts_[i], &clock, &region, part_trace);
      // A region that the cylinder has left, or that cuts its sides off, must not cost the frame.
      if (estimate.status != PoseStatus::kOk && search != image.bounds()) {
        search = image.bounds();
        if (part_trace != nullptr) *part_trace = {};
        estimate = estimate_part(image, search, parts_[i], &clock, &region, part_trace);
      }
      // "The ROI of the last pose estimation": without a pose there is none, and the whole image is searched.
      last_boxes_[i] = estimate.status == PoseStatus::kOk ? region.box : Roi{};
      frame.searched = united(frame.searched, search);
      frame.parts.push_back(std::move(estimate));
    }
    frame.times = clock.times();
    return frame;
  }

  void reset() override { last_boxes_.assign(parts_.size(), {}); }

 private:
  [[nodiscard]] PoseEstimate estimate_part(const ImageView& image, const Roi& search, const PartModel& part,
                                           StageClock* clock, RegionStatistics* region, PartTrace* trace) const {
    clock->skip();  // the trace of the part before
    Mask mask = thesis_gate(image, search, part);
    clock->lap("gate");
    thesis_morphology(&mask);
    clock->lap("morphology");
    *region = thesis_statistics(mask);
    clock->lap("statistics");
    if (region->m00 == 0) {
      if (trace != nullptr) trace->mask = std::move(mask);
      return none("no pixel of the part's colour is left after erosion");
    }
    const Mask edge_image = thesis_canny(mask, region->box);
    clock->lap("canny");
    const auto edges = thesis_edges(edge_image, options_.min_edge_size);
    clock->lap("contours");
    if (trace != nullptr) {
      trace->mask = std::move(mask);
      trace->edges = pixels_of(edge_image);
      trace->chains = edges;
      clock->skip();
    }
    const Eigen::Vector2d mean_pixel(region->mean_x(), region->mean_y());
    const Eigen::Vector2d mean = thesis_ideal_points(camera_, {&mean_pixel, 1}).front();
    const std::vector<ThesisLine> lines = find_lines(edges, mean, trace);
    clock->lap("lines");
    if (trace != nullptr) {
      for (const ThesisLine& line : lines) trace->lines.push_back(frame_line(camera_, shifted(line, mean)));
      clock->skip();
    }
    PoseEstimate estimate = pose_from(lines, *region, mean, part, edge_image);
    clock->lap("pose");
    return estimate;
  }

  // All straight lines, relative to the region's mean, best supported first.
  [[nodiscard]] std::vector<ThesisLine> find_lines(const std::vector<std::vector<Eigen::Vector2d>>& edges,
                                                   const Eigen::Vector2d& mean, PartTrace* trace) const {
    std::vector<ThesisLine> lines;
    for (const std::vector<Eigen::Vector2d>& edge : edges) {
      std::vector<Eigen::Vector2d> local = thesis_ideal_points(camera_, edge);
      for (Eigen::Vector2d& point : local) point -= mean;
      for (const EdgePiece& piece : thesis_pieces(local, options_.min_edge_size, options_.max_chord_distance_px)) {
        const auto begin = static_cast<std::ptrdiff_t>(piece.begin);
        const auto end = static_cast<std::ptrdiff_t>(piece.end);
        if (trace != nullptr) trace->segments.emplace_back(edge.begin() + begin, edge.begin() + end);
        ThesisLine line = thesis_fitted_line({local.begin() + begin, local.begin() + end});
        if (is_straight(line, options_)) lines.push_back(std::move(line));
      }
    }
    return thesis_combined(std::move(lines), options_);
  }

  [[nodiscard]] PoseEstimate pose_from(const std::vector<ThesisLine>& lines, const RegionStatistics& region,
                                       const Eigen::Vector2d& mean, const PartModel& part,
                                       const Mask& edge_image) const {
    const double focal_px = thesis_focal_px(camera_);
    PoseEstimate estimate;
    auto sides = thesis_candidates(lines, region, options_, &estimate.reason);
    if (!sides) return estimate;
    for (ThesisLine& side : *sides) side = shifted(std::move(side), mean);
    const auto pose = thesis_pose_from_lines(ideal_line((*sides)[0]), ideal_line((*sides)[1]), mean, focal_px,
                                             part.radius_m, &estimate.reason);
    if (!pose) return estimate;
    if (!side_planes(*pose, part.radius_m)) return none("the camera would be inside the cylinder");
    const auto covariance = thesis_covariance(*sides, mean, focal_px, part);
    if (!covariance) return none("the two side lines are on the verge of having no cylinder");
    estimate.status = PoseStatus::kOk;
    estimate.pose = *pose;
    estimate.covariance = *covariance;
    estimate.rms_px = thesis_rms_px(*pose, part.radius_m, *sides, focal_px);
    estimate.support = static_cast<int>((*sides)[0].points.size() + (*sides)[1].points.size());
    estimate.seen = thesis_seen(*pose, part, camera_, edge_image);
    estimate.sides = {frame_line(camera_, (*sides)[0]), frame_line(camera_, (*sides)[1])};
    return estimate;
  }

  CameraModel camera_;
  std::vector<PartModel> parts_;
  ThesisOptions options_;
  std::vector<Roi> last_boxes_;  // of each part; empty where the last frame gave no pose
};

}  // namespace

std::unique_ptr<Estimator> make_thesis_estimator(const CameraModel& camera, const std::vector<PartModel>& parts,
                                                 const ThesisOptions& options) {
  std::string why;
  if (!camera.is_valid(&why)) throw Error(ErrorKind::kInput, "camera: " + why);
  if (parts.empty()) throw Error(ErrorKind::kInput, "no parts to look for; describe at least one");
  for (const PartModel& part : parts) {
    if (!part.is_valid(&why)) throw Error(ErrorKind::kInput, fmt::format("part '{}': {}", part.name, why));
  }
  if (!options.is_valid(&why)) throw Error(ErrorKind::kInput, "options of the thesis's method: " + why);
  return std::make_unique<ThesisEstimator>(camera, parts, options);
}

}  // namespace cylpose
