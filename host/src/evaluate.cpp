#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cylpose/error.hpp>
#include <cylpose/evaluate.hpp>
#include <map>
#include <numbers>
#include <numeric>
#include <set>
#include <utility>

namespace cylpose {
namespace {

using RowId = std::pair<std::int64_t, std::string>;  // frame, part

void require_pose(const CylinderPose& pose, const char* whose) {
  constexpr double kRounding = 1e-6;
  if (!pose.center_in_cam.allFinite() || !(std::abs(pose.axis_in_cam.norm() - 1) < kRounding)) {
    throw Error(
        ErrorKind::kInput,
        fmt::format("the {} pose, centre ({}, {}, {}) and axis ({}, {}, {}), cannot be compared; expected finite "
                    "numbers and a unit vector",
                    whose, pose.center_in_cam.x(), pose.center_in_cam.y(), pose.center_in_cam.z(), pose.axis_in_cam.x(),
                    pose.axis_in_cam.y(), pose.axis_in_cam.z()));
  }
}

/// `sorted` is not empty; `share` from 0 to 1.
double quantile(const std::vector<double>& sorted, double share) {
  const double place = share * static_cast<double>(sorted.size() - 1);
  const auto below = static_cast<std::size_t>(place);
  const std::size_t above = std::min(below + 1, sorted.size() - 1);
  return std::lerp(sorted[below], sorted[above], place - static_cast<double>(below));
}

/// The part that rows of a truth without part names belong to.
std::string only_part_of(std::span<const PoseRow> poses, const EvaluateOptions& options) {
  if (!options.part.empty()) return options.part;
  std::set<std::string> names;
  for (const PoseRow& row : poses) names.insert(row.part);
  if (names.size() > 1) {
    throw Error(ErrorKind::kInput,
                fmt::format("the poses hold the parts {} and the truth has no column 'part'; name the part to compare",
                            fmt::join(names, ", ")));
  }
  return names.empty() ? std::string() : *names.begin();
}

std::string described(const RowId& id) {
  return id.second.empty() ? fmt::format("frame {}", id.first) : fmt::format("frame {}, part {}", id.first, id.second);
}

template <typename Row>
void insert_once(std::map<RowId, const Row*>* rows, RowId id, const Row& row, const char* where) {
  if (!rows->emplace(id, &row).second) {
    throw Error(ErrorKind::kInput,
                fmt::format("{}: given twice in the {}; each frame and part may have one row", described(id), where));
  }
}

std::map<RowId, const TruthRow*> by_id(std::span<const TruthRow> truth, std::span<const PoseRow> poses,
                                       const EvaluateOptions& options) {
  std::map<RowId, const TruthRow*> rows;
  const bool named = std::any_of(truth.begin(), truth.end(), [](const TruthRow& row) { return !row.part.empty(); });
  const std::string only_part = named ? std::string() : only_part_of(poses, options);
  for (const TruthRow& row : truth) {
    const std::string& part = named ? row.part : only_part;
    if (options.part.empty() || part == options.part) insert_once(&rows, {row.frame, part}, row, "truth");
  }
  return rows;
}

std::map<RowId, const PoseRow*> by_id(std::span<const PoseRow> poses, const EvaluateOptions& options) {
  std::map<RowId, const PoseRow*> rows;
  for (const PoseRow& row : poses) {
    if (options.part.empty() || row.part == options.part) insert_once(&rows, {row.frame, row.part}, row, "poses");
  }
  return rows;
}

std::optional<Statistics> statistics_of_member(const std::vector<PoseError>& errors, double PoseError::*member) {
  std::vector<double> values(errors.size());
  std::transform(errors.begin(), errors.end(), values.begin(), [&](const PoseError& error) { return error.*member; });
  return statistics_of(std::move(values));
}

}  // namespace

PoseError pose_error(const CylinderPose& estimated, const CylinderPose& truth) {
  require_pose(estimated, "estimated");
  require_pose(truth, "true");
  const Eigen::Vector3d e = estimated.center_in_cam - truth.center_in_cam;
  const Eigen::Vector3d sight = truth.center_in_cam.normalized();
  const Eigen::Vector3d across = sight.cross(truth.axis_in_cam);  // l, not yet of unit length
  const Eigen::Vector3d e_across_sight = e - sight * sight.dot(e);

  PoseError error;
  error.position_m = e.norm();
  error.depth_m = std::abs(e.dot(sight));
  error.lateral_m = e_across_sight.norm();
  constexpr double kPointsAtCamera = 1e-9;
  if (across.norm() > kPointsAtCamera) {
    const Eigen::Vector3d lateral = across.normalized();
    error.lateral_m = std::abs(e.dot(lateral));
    error.along_axis_m = std::abs(e.dot(lateral.cross(sight)));
  }
  error.axis_line_m = e.cross(estimated.axis_in_cam).norm();
  const double sine = estimated.axis_in_cam.cross(truth.axis_in_cam).norm();
  const double cosine = std::abs(estimated.axis_in_cam.dot(truth.axis_in_cam));
  error.axis_angle_deg = std::atan2(sine, cosine) * 180 / std::numbers::pi;
  return error;
}

std::optional<Statistics> statistics_of(std::vector<double> values) {
  if (values.empty()) return std::nullopt;
  for (const double value : values) {
    if (!std::isfinite(value)) throw Error(ErrorKind::kInput, fmt::format("{} has no place in statistics", value));
  }
  std::sort(values.begin(), values.end());
  return Statistics{std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size()),
                    quantile(values, 0.5), quantile(values, 0.95), values.back()};
}

bool EvaluateOptions::is_valid(std::string* why) const {
  if (wrong_axis_deg >= 0 && wrong_axis_deg <= 90) return true;
  if (why != nullptr) *why = fmt::format("wrong_axis_deg is {}; give 0..90", wrong_axis_deg);
  return false;
}

double Evaluation::found_rate() const {
  return static_cast<double>(ok) / static_cast<double>(expected);
}

std::vector<std::string> Evaluation::warnings() const {
  std::vector<std::string> all;
  if (missing > 0) {
    all.push_back(
        fmt::format("{} of {} rows of the truth have no row in the poses; they count as not found", missing, expected));
  }
  if (surplus > 0) all.push_back(fmt::format("{} rows of the poses have no truth; they do not count", surplus));
  return all;
}

Evaluation evaluate(std::span<const TruthRow> truth, std::span<const PoseRow> poses, const EvaluateOptions& options) {
  std::string why;
  if (!options.is_valid(&why)) throw Error(ErrorKind::kInput, why);
  const std::map<RowId, const PoseRow*> pose_rows = by_id(poses, options);
  Evaluation result;
  result.wrong_axis_deg = options.wrong_axis_deg;
  std::vector<PoseError> errors;
  for (const auto& [id, row] : by_id(truth, poses, options)) {
    ++result.expected;
    const auto found = pose_rows.find(id);
    if (found == pose_rows.end()) {
      ++result.missing;
    } else if (found->second->status == PoseStatus::kNone) {
      ++result.none;
    } else if (found->second->status == PoseStatus::kPredicted) {
      ++result.predicted;
    } else {
      ++result.ok;
      errors.push_back(pose_error(found->second->pose, row->pose));
      if (errors.back().axis_angle_deg > options.wrong_axis_deg) ++result.wrong;
    }
  }
  const std::int64_t matched = result.expected - result.missing;
  result.surplus = static_cast<std::int64_t>(pose_rows.size()) - matched;
  if (matched == 0) {
    throw Error(ErrorKind::kInput,
                fmt::format("truth ({} rows) and poses ({} rows){} have no frame and part in common; do they belong "
                            "together, and are the parts named alike?",
                            result.expected, pose_rows.size(),
                            options.part.empty() ? "" : fmt::format(" of part {}", options.part)));
  }
  result.position_m = statistics_of_member(errors, &PoseError::position_m);
  result.depth_m = statistics_of_member(errors, &PoseError::depth_m);
  result.lateral_m = statistics_of_member(errors, &PoseError::lateral_m);
  result.along_axis_m = statistics_of_member(errors, &PoseError::along_axis_m);
  result.axis_line_m = statistics_of_member(errors, &PoseError::axis_line_m);
  result.axis_angle_deg = statistics_of_member(errors, &PoseError::axis_angle_deg);
  return result;
}

}  // namespace cylpose
