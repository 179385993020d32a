#include "series.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cylpose/error.hpp>
#include <limits>
#include <map>

namespace cylpose {
namespace {

bool is_finite(const PoseRow& row) {
  return row.pose.center_in_cam.allFinite() && row.pose.axis_in_cam.allFinite() && row.sigma_center_m.allFinite() &&
         std::isfinite(row.sigma_axis_deg) && std::isfinite(row.rms_px);
}

std::vector<PoseRow> finite_rows(const std::vector<PoseRow>& rows, std::size_t* not_finite) {
  std::vector<PoseRow> result = rows;
  for (PoseRow& row : result) {
    if (row.status == PoseStatus::kNone || is_finite(row)) continue;
    row.status = PoseStatus::kNone;
    row.reason = "its numbers are not finite";
    ++*not_finite;
  }
  return result;
}

/// The truth's rows with the part each one belongs to.
std::vector<TruthRow> with_part_names(std::vector<TruthRow> truth, const std::vector<PartSeries>& parts) {
  if (std::any_of(truth.begin(), truth.end(), [](const TruthRow& row) { return !row.part.empty(); })) return truth;
  if (parts.size() > 1 && !truth.empty()) {
    throw Error(ErrorKind::kInput,
                fmt::format("the poses hold {} parts and the truth has no column 'part'; add it, or compare one part",
                            parts.size()));
  }
  for (TruthRow& row : truth) row.part = parts.empty() ? std::string() : parts.front().name;
  return truth;
}

PartSeries& part_named(std::vector<PartSeries>* parts, const std::string& name) {
  const auto known = std::find_if(parts->begin(), parts->end(), [&](const PartSeries& p) { return p.name == name; });
  if (known != parts->end()) return *known;
  parts->emplace_back();
  parts->back().name = name;
  return parts->back();
}

template <typename Value>
void put_once(std::optional<Value>* place, const Value& value, std::int64_t frame, const std::string& part,
              const char* where) {
  if (place->has_value()) {
    throw Error(ErrorKind::kInput, fmt::format("frame {}, part {}: given twice in the {}; each frame and part may "
                                               "have one row",
                                               frame, part, where));
  }
  *place = value;
}

/// Compares where frames are in common; evaluate() refuses to compare nothing.
void compare(PartSeries* part, const std::vector<PoseRow>& poses, const std::vector<TruthRow>& truth) {
  bool in_common = false;
  for (std::size_t i = 0; i < part->poses.size(); ++i) {
    if (!part->poses[i] || !part->truth[i]) continue;
    in_common = true;
    if (part->poses[i]->status == PoseStatus::kOk) part->errors[i] = pose_error(part->poses[i]->pose, *part->truth[i]);
  }
  if (in_common) part->evaluation = evaluate(truth, poses, {.part = part->name});
}

/// How much a frame stands out.
double salience(const RunSeries& run, std::size_t frame) {
  double most = -1;
  for (const PartSeries& part : run.parts) {
    const std::optional<PoseRow>& row = part.poses[frame];
    if (!row || row->status != PoseStatus::kOk) return std::numeric_limits<double>::infinity();
    most = std::max(most, part.errors[frame] ? part.errors[frame]->position_m : row->rms_px);
  }
  return most;
}

}  // namespace

RunSeries series_of(const Report& report) {
  RunSeries run;
  const std::vector<PoseRow> poses = finite_rows(report.poses, &run.not_finite);
  std::map<std::int64_t, std::size_t> places;
  for (const PoseRow& row : poses) {
    places[row.frame] = 0;
    (void)part_named(&run.parts, row.part);
  }
  const std::vector<TruthRow> truth = with_part_names(report.truth, run.parts);
  for (const TruthRow& row : truth) {
    places[row.frame] = 0;
    (void)part_named(&run.parts, row.part);
  }
  for (auto& [frame, place] : places) {
    place = run.frames.size();
    run.frames.push_back(frame);
  }
  run.timestamp_s.resize(run.frames.size());
  for (PartSeries& part : run.parts) {
    part.poses.resize(run.frames.size());
    part.truth.resize(run.frames.size());
    part.errors.resize(run.frames.size());
  }
  for (const PoseRow& row : poses) {
    const std::size_t place = places.at(row.frame);
    put_once(&part_named(&run.parts, row.part).poses[place], row, row.frame, row.part, "poses");
    if (std::isfinite(row.timestamp_s)) run.timestamp_s[place] = row.timestamp_s;
  }
  for (const TruthRow& row : truth) {
    put_once(&part_named(&run.parts, row.part).truth[places.at(row.frame)], row.pose, row.frame, row.part, "truth");
  }
  for (PartSeries& part : run.parts) compare(&part, poses, truth);
  return run;
}

std::vector<std::size_t> plotted_frames(const RunSeries& run, std::size_t limit) {
  const std::size_t all = run.frames.size();
  const std::size_t step = (all + limit - 1) / limit;
  std::vector<std::size_t> plotted;
  for (std::size_t first = 0; first < all; first += step) {
    std::size_t chosen = first;
    for (std::size_t i = first + 1; i < std::min(first + step, all); ++i) {
      if (salience(run, i) > salience(run, chosen)) chosen = i;
    }
    plotted.push_back(chosen);
  }
  return plotted;
}

}  // namespace cylpose
