#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <array>
#include <cmath>
#include <cylpose/error.hpp>
#include <cylpose/outline.hpp>
#include <cylpose/pose_filter.hpp>
#include <cylpose/search_region.hpp>
#include <limits>
#include <optional>
#include <utility>

#include "option_check.hpp"
#include "part_track.hpp"

namespace cylpose {
namespace {

[[noreturn]] void refuse(std::string text) {
  throw Error(ErrorKind::kInput, "pose filter: " + std::move(text));
}

void require_measured(const PartModel& part, const PoseEstimate& measured) {
  if (measured.status == PoseStatus::kNone) return;
  if (measured.status == PoseStatus::kPredicted) {
    refuse(fmt::format("part '{}' has the status predicted; give measurements, not what a filter made", part.name));
  }
  const Eigen::Vector3d& center = measured.pose.center_in_cam;
  const Eigen::Vector3d& axis = measured.pose.axis_in_cam;
  constexpr double kUnitTolerance = 1e-6;
  if (!center.allFinite() || !(std::abs(axis.norm() - 1) <= kUnitTolerance)) {
    refuse(
        fmt::format("part '{}' has the centre ({}, {}, {}) and the axis ({}, {}, {}); they must be finite and a unit "
                    "vector",
                    part.name, center.x(), center.y(), center.z(), axis.x(), axis.y(), axis.z()));
  }
  Eigen::Matrix<double, 6, 5> observable = Eigen::Matrix<double, 6, 5>::Zero();
  observable.topLeftCorner<3, 3>().setIdentity();
  observable.block<3, 1>(3, 3) = axis.unitOrthogonal();
  observable.block<3, 1>(3, 4) = axis.cross(axis.unitOrthogonal());
  const Eigen::Matrix<double, 5, 5> covariance = observable.transpose() * measured.covariance * observable;
  if (!measured.covariance.allFinite() || covariance.llt().info() != Eigen::Success) {
    refuse(
        fmt::format("the covariance of part '{}' is not finite or not positive definite (variances {}); state the "
                    "uncertainty of centre and axis",
                    part.name, fmt::join(measured.covariance.diagonal(), ", ")));
  }
}

// The normals are zero where no sides are seen.
std::array<ImageLine, 2> sides_of(const CameraModel& camera, const PartModel& part, const CylinderPose& pose) {
  if (const auto outline = Outline::of(camera, part, pose)) return outline->sides();
  const ImageLine unseen{Eigen::Vector2d::Zero(), 0};
  return {unseen, unseen};
}

// Box of real pixel coordinates that grows with every point.
struct PixelBox {
  Eigen::Array2d low = Eigen::Array2d::Constant(std::numeric_limits<double>::infinity());
  Eigen::Array2d high = -low;

  void add(const Eigen::Vector2d& pixel) {
    low = low.min(pixel.array());
    high = high.max(pixel.array());
  }
};

// The pixels that the part covers at any pose within `sigmas` of the predicted one: the corners of the box around the
// cylinder, moved as far as the covariance allows to where they move most in the image. None when that is behind the
// camera.
std::optional<Roi> covered(const CameraModel& camera, const PartModel& part, const MotionFilter& track, double sigmas) {
  PixelBox box;
  for (const double x : {-part.radius_m, part.radius_m}) {
    for (const double y : {-part.radius_m, part.radius_m}) {
      for (const double z : {-part.height_m / 2, part.height_m / 2}) {
        const Eigen::Vector3d corner = track.point_in_cam({x, y, z});
        const Eigen::Matrix3d covariance = track.point_covariance({x, y, z});
        for (const Eigen::Index direction : {0, 1}) {
          // The image coordinate is proportional to corner[direction] / z: this is its gradient, but for a factor.
          Eigen::Vector3d gradient = corner.z() * Eigen::Vector3d::Unit(direction);
          gradient.z() = -corner[direction];
          const Eigen::Vector3d move = sigmas * covariance * gradient / std::sqrt(gradient.dot(covariance * gradient));
          for (const double sign : {-1.0, 1.0}) {
            const Eigen::Vector3d moved = corner + sign * move;
            if (!(moved.z() > 0)) return std::nullopt;
            box.add(project(camera, moved));
          }
        }
      }
    }
  }
  // Far outside the image the numbers may be too large for int: cut first.
  const Eigen::Array2d size(camera.width, camera.height);
  const Eigen::Array2i low = box.low.max(-size).min(2 * size).floor().cast<int>() - SearchRegion::kMinMarginPx;
  const Eigen::Array2i high = box.high.max(-size).min(2 * size).ceil().cast<int>() + SearchRegion::kMinMarginPx;
  return intersection({low.x(), low.y(), high.x() - low.x() + 1, high.y() - low.y() + 1},
                      {0, 0, camera.width, camera.height});
}

}  // namespace

FilterOptions FilterOptions::hand_held() {
  FilterOptions options;
  options.velocity_drift_m_s = 1.5;
  options.rate_drift_rad_s = 6;
  options.start_speed_m_s = 2;
  options.start_rate_rad_s = 5;
  return options;
}

bool FilterOptions::is_valid(std::string* why) const {
  const std::pair<double, const char*> numbers[] = {{velocity_drift_m_s, "velocity_drift_m_s"},
                                                    {rate_drift_rad_s, "rate_drift_rad_s"},
                                                    {start_speed_m_s, "start_speed_m_s"},
                                                    {start_rate_rad_s, "start_rate_rad_s"},
                                                    {covariance_scale, "covariance_scale"},
                                                    {gate_chi2, "gate_chi2"},
                                                    {max_coast_s, "max_coast_s"},
                                                    {max_center_sigma_m, "max_center_sigma_m"},
                                                    {max_axis_sigma_deg, "max_axis_sigma_deg"}};
  for (const auto& [value, name] : numbers) {
    if (!require_positive(value, name, why)) return false;
    if (std::isinf(value)) return invalid(why, fmt::format("{} is infinite; must be a number", name));
  }
  return require_at_least(confirm_frames, 1, "confirm_frames", why) &&
         require_at_least(switch_frames, confirm_frames, "switch_frames", why);
}

struct PoseFilter::State {
  CameraModel camera;
  std::vector<PartModel> parts;
  FilterOptions options;
  std::vector<PartTrack> tracks;
  std::optional<double> last_s;
};

PoseFilter::PoseFilter(CameraModel camera, std::vector<PartModel> parts, FilterOptions options)
    : state_(std::make_unique<State>(State{std::move(camera), std::move(parts), options, {}, {}})) {
  std::string why;
  if (!state_->camera.is_valid(&why)) refuse("camera: " + why);
  if (state_->parts.empty()) refuse("no parts; give one at least");
  for (const PartModel& part : state_->parts) {
    if (!part.is_valid(&why)) refuse(fmt::format("part '{}': {}", part.name, why));
  }
  if (!options.is_valid(&why)) refuse("options: " + why);
  reset();
}

PoseFilter::~PoseFilter() = default;
PoseFilter::PoseFilter(const PoseFilter& other) : state_(std::make_unique<State>(*other.state_)) {}
PoseFilter& PoseFilter::operator=(const PoseFilter& other) {
  if (this != &other) state_ = std::make_unique<State>(*other.state_);
  return *this;
}
PoseFilter::PoseFilter(PoseFilter&&) noexcept = default;
PoseFilter& PoseFilter::operator=(PoseFilter&&) noexcept = default;

std::vector<PoseEstimate> PoseFilter::update(double timestamp_s, std::span<const PoseEstimate> measured) {
  const auto& [camera, parts, options, tracks, last_s] = *state_;
  if (!std::isfinite(timestamp_s) || (last_s && timestamp_s <= *last_s)) {
    refuse(
        fmt::format("time stamp {} s after {}; stamps must increase: leave the frame out, or reset the filter when "
                    "a stream begins anew",
                    timestamp_s, last_s ? fmt::format("{} s", *last_s) : "the start"));
  }
  if (measured.size() != parts.size()) {
    refuse(fmt::format("{} parts but {} estimates; give one each", parts.size(), measured.size()));
  }
  for (std::size_t i = 0; i < parts.size(); ++i) require_measured(parts[i], measured[i]);

  state_->last_s = timestamp_s;
  std::vector<PoseEstimate> filtered;
  filtered.reserve(parts.size());
  for (std::size_t i = 0; i < parts.size(); ++i) {
    PoseEstimate estimate = state_->tracks[i].update(timestamp_s, measured[i]);
    if (estimate.status == PoseStatus::kPredicted) estimate.sides = sides_of(camera, parts[i], estimate.pose);
    filtered.push_back(std::move(estimate));
  }
  return filtered;
}

Roi PoseFilter::search_region(double timestamp_s) const {
  const auto& [camera, parts, options, tracks, last_s] = *state_;
  if (!std::isfinite(timestamp_s) || (last_s && timestamp_s < *last_s)) {
    refuse(fmt::format("search region at {} s, before the last frame's {}; ask for a later time", timestamp_s,
                       last_s ? fmt::format("{} s", *last_s) : "start"));
  }
  const Roi whole{0, 0, camera.width, camera.height};
  Roi all;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const auto track = tracks[i].predicted(timestamp_s);
    const auto box = track ? covered(camera, parts[i], *track, std::sqrt(options.gate_chi2)) : std::nullopt;
    if (!box || box->empty()) return whole;
    all = united(all, *box);
  }
  return all;
}

void PoseFilter::reset() {
  state_->last_s.reset();
  state_->tracks.clear();
  for (const PartModel& part : state_->parts) state_->tracks.emplace_back(part, state_->options);
}

}  // namespace cylpose
