// The rows of a report, put in order: frame by frame, part by part, poses beside the truth.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cylpose/evaluate.hpp>
#include <cylpose/report.hpp>
#include <optional>
#include <string>
#include <vector>

namespace cylpose {

inline constexpr double kMillimetres = 1000;  ///< of a metre

/// One part; all lists have an entry per frame of the run.
struct PartSeries {
  std::string name;
  std::vector<std::optional<PoseRow>> poses;  ///< none: no row for this frame
  std::vector<std::optional<CylinderPose>> truth;
  std::vector<std::optional<PoseError>> errors;  ///< of the `ok` poses that have a truth
  std::optional<Evaluation> evaluation;          ///< where poses and truth have frames in common
};

struct RunSeries {
  std::vector<std::int64_t> frames;  ///< all that poses or truth name, ascending
  std::vector<std::optional<double>> timestamp_s;
  std::vector<PartSeries> parts;  ///< in order of first appearance
  std::size_t not_finite = 0;     ///< poses that were made `none` because of it
};

/// Throws as to_html() does.
[[nodiscard]] RunSeries series_of(const Report& report);

/// The frames to plot when at most `limit` may be (at least 1): all, or of every run of n frames the one that stands
/// out, which is the first with a part that is not `ok`, else that of the largest error, or residual without truth.
/// Indices into RunSeries::frames, ascending.
[[nodiscard]] std::vector<std::size_t> plotted_frames(const RunSeries& run, std::size_t limit);

}  // namespace cylpose
