// How far poses are from the truth.
#pragma once

#include <cstdint>
#include <cylpose/cylinder.hpp>
#include <cylpose/pose_io.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace cylpose {

/// The error of one pose, all values >= 0. With s the unit vector from the camera to the true centre (line of sight), a
/// the true axis as seen along it (its component perpendicular to s, normalised) and l = s x a, the error e of the
/// centre is split into three perpendicular parts: position^2 = depth^2 + along_axis^2 + lateral^2.
struct PoseError {
  double position_m = 0;      ///< |e|
  double depth_m = 0;         ///< |e . s|
  double along_axis_m = 0;    ///< |e . a|; 0 where the axis points at the camera and a does not exist
  double lateral_m = 0;       ///< |e . l|; all that is perpendicular to s where a does not exist
  double axis_line_m = 0;     ///< distance of the true centre from the estimated axis line
  double axis_angle_deg = 0;  ///< angle of the axes, whatever their signs: 0..90
};

/// Throws Error(kInput) for numbers that are not finite and for axes that are no unit vectors: a comparison with NaN
/// would count as no error.
[[nodiscard]] PoseError pose_error(const CylinderPose& estimated, const CylinderPose& truth);

struct Statistics {
  double mean = 0;
  double median = 0;
  double p95 = 0;  ///< 95th percentile; quantiles are interpolated linearly between the sorted values
  double max = 0;
};

/// None for no values. Throws Error(kInput) for values that are not finite.
[[nodiscard]] std::optional<Statistics> statistics_of(std::vector<double> values);

struct EvaluateOptions {
  std::string part = {};       ///< only this part; empty: all
  double wrong_axis_deg = 10;  ///< an `ok` pose whose axis is off by more is wrong. Range 0..90

  [[nodiscard]] bool is_valid(std::string* why) const;
};

/// Every row of the truth is expected to have an `ok` row for its frame and part.
struct Evaluation {
  std::int64_t expected = 0;  ///< rows of the truth = ok + predicted + none + missing
  std::int64_t ok = 0;
  std::int64_t predicted = 0;
  std::int64_t none = 0;
  std::int64_t missing = 0;   ///< rows of the truth without a row in the poses
  std::int64_t surplus = 0;   ///< rows of the poses without truth; they do not count
  std::int64_t wrong = 0;     ///< of `ok`
  double wrong_axis_deg = 0;  ///< what counted as wrong

  /// Of the `ok` rows, wrong ones included; none when there are no such rows. The mean of `position_m` is the thesis's
  /// equation 5.4.
  std::optional<Statistics> position_m, depth_m, lateral_m, along_axis_m, axis_line_m, axis_angle_deg;

  [[nodiscard]] double found_rate() const;                  ///< ok / expected
  [[nodiscard]] std::vector<std::string> warnings() const;  ///< about missing and surplus rows, with counts
};

/// Matches rows by frame and part; a truth without part names belongs to the one part of the poses. Throws
/// Error(kInput) when rows are given twice, when it is unclear which part the truth belongs to, or when there is
/// nothing to compare.
[[nodiscard]] Evaluation evaluate(std::span<const TruthRow> truth, std::span<const PoseRow> poses,
                                  const EvaluateOptions& options = {});

/// A table for people, millimetres and degrees.
[[nodiscard]] std::string to_text(const Evaluation& evaluation);

/// One JSON object, metres and degrees; statistics without values are null.
[[nodiscard]] std::string to_json(const Evaluation& evaluation);

}  // namespace cylpose
