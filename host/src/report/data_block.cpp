#include "data_block.hpp"

#include <cmath>
#include <cstddef>
#include <cylpose/html_page.hpp>
#include <cylpose/version.hpp>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>

#include "histogram.hpp"

namespace cylpose {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kColumnBytes = 20;        // 17 digits, sign, point and comma
constexpr std::size_t kPlotBudget = 4'200'000;  // bytes: with all else the page stays below 5 MB

/// Derived numbers, that no file holds: six digits.
Json rounded(double value) {
  if (value == 0 || !std::isfinite(value)) return value;
  const double scale = std::pow(10, 5 - std::floor(std::log10(std::abs(value))));
  return std::isfinite(scale) ? std::round(value * scale) / scale : value;
}

/// One column: an entry per plotted frame, null where `value` gives none.
template <typename Value>
Json column(const std::vector<std::size_t>& plotted, const Value& value) {
  Json values = Json::array();
  for (const std::size_t frame : plotted) values.push_back(value(frame));
  return values;
}

/// A column of what some frames do not have: null there.
template <typename Row, typename Value>
Json column_of(const std::vector<std::size_t>& plotted, const std::vector<std::optional<Row>>& rows,
               const Value& value) {
  return column(plotted, [&](std::size_t frame) { return rows[frame] ? Json(value(*rows[frame])) : Json(nullptr); });
}

void add_vector(Json* columns, const std::string& prefix, const std::function<Json(int)>& component) {
  constexpr const char* kAxes[] = {"x", "y", "z"};
  for (int i = 0; i < 3; ++i) (*columns)[prefix + kAxes[i]] = component(i);
}

Json pose_columns(const PartSeries& part, const std::vector<std::size_t>& plotted) {
  const auto of_pose = [&](auto value) {
    return column_of(plotted, part.poses,
                     [&](const PoseRow& row) { return row.status == PoseStatus::kNone ? Json(nullptr) : value(row); });
  };
  Json columns;
  columns["status"] =
      column_of(plotted, part.poses, [](const PoseRow& row) { return std::string(to_string(row.status)); });
  add_vector(&columns, "c",
             [&](int i) { return of_pose([i](const PoseRow& row) { return Json(row.pose.center_in_cam[i]); }); });
  add_vector(&columns, "a",
             [&](int i) { return of_pose([i](const PoseRow& row) { return Json(row.pose.axis_in_cam[i]); }); });
  add_vector(&columns, "sigma_c",
             [&](int i) { return of_pose([i](const PoseRow& row) { return Json(row.sigma_center_m[i]); }); });
  columns["sigma_axis_deg"] = of_pose([](const PoseRow& row) { return Json(row.sigma_axis_deg); });
  columns["rms_px"] = of_pose([](const PoseRow& row) { return Json(row.rms_px); });
  return columns;
}

Json truth_columns(const PartSeries& part, const std::vector<std::size_t>& plotted) {
  Json columns;
  add_vector(&columns, "c", [&](int i) {
    return column_of(plotted, part.truth, [i](const CylinderPose& pose) { return pose.center_in_cam[i]; });
  });
  add_vector(&columns, "a", [&](int i) {
    return column_of(plotted, part.truth, [i](const CylinderPose& pose) { return pose.axis_in_cam[i]; });
  });
  return columns;
}

Json error_columns(const PartSeries& part, const std::vector<std::size_t>& plotted) {
  const auto of_error = [&](double PoseError::*member) {
    return column_of(plotted, part.errors, [&](const PoseError& error) { return rounded(error.*member); });
  };
  Json columns;
  columns["depth_m"] = of_error(&PoseError::depth_m);
  columns["lateral_m"] = of_error(&PoseError::lateral_m);
  columns["along_axis_m"] = of_error(&PoseError::along_axis_m);
  columns["axis_angle_deg"] = of_error(&PoseError::axis_angle_deg);
  return columns;
}

Json histogram_json(const char* title, const char* unit, std::vector<double> values) {
  const Histogram histogram = histogram_of(std::move(values));
  return {{"title", title},           {"unit", unit},
          {"step", histogram.step},   {"counts", histogram.counts},
          {"above", histogram.above}, {"max", rounded(histogram.max)}};
}

Json histograms(const PartSeries& part) {
  Json all = Json::array();
  const auto add = [&](const char* title, const char* unit, std::vector<double> values) {
    if (!values.empty()) all.push_back(histogram_json(title, unit, std::move(values)));
  };
  const auto of_error = [&](double PoseError::*member, double factor) {
    std::vector<double> values;
    for (const auto& error : part.errors) {
      if (error) values.push_back(factor * ((*error).*member));
    }
    return values;
  };
  add("Depth error", "mm", of_error(&PoseError::depth_m, kMillimetres));
  add("Lateral error", "mm", of_error(&PoseError::lateral_m, kMillimetres));
  add("Error along the axis", "mm", of_error(&PoseError::along_axis_m, kMillimetres));
  add("Distance from the axis line", "mm", of_error(&PoseError::axis_line_m, kMillimetres));
  add("Axis angle error", "deg", of_error(&PoseError::axis_angle_deg, 1));
  std::vector<double> residuals;
  for (const auto& row : part.poses) {
    if (row && row->status == PoseStatus::kOk) residuals.push_back(row->rms_px);
  }
  add("Residual (rms)", "px", std::move(residuals));
  return all;
}

Json part_json(const PartSeries& part, const std::vector<std::size_t>& plotted, bool has_truth) {
  Json json;
  json["name"] = part.name;
  json.update(pose_columns(part, plotted));
  if (has_truth) {
    json["truth"] = truth_columns(part, plotted);
    json["error"] = error_columns(part, plotted);
  }
  json["histograms"] = histograms(part);
  return json;
}

std::size_t plot_limit(std::size_t parts, bool has_truth) {
  const std::size_t per_part = (has_truth ? 19 : 12) * kColumnBytes;
  return std::max<std::size_t>(kPlotBudget / (std::max<std::size_t>(parts, 1) * per_part), 1);
}

Json times_json(const Report& report, const RunSeries& run, const std::vector<std::size_t>& plotted) {
  std::map<std::int64_t, double> by_frame;
  for (const FrameTime& time : report.frame_times) by_frame[time.frame] = time.milliseconds;
  return column(plotted, [&](std::size_t frame) {
    const auto time = by_frame.find(run.frames[frame]);
    // The clock's own resolution is a microsecond.
    return time == by_frame.end() ? Json(nullptr) : Json(std::round(1000 * time->second) / 1000);
  });
}

}  // namespace

std::string data_block(const Report& report, const RunSeries& run) {
  const bool has_truth = !report.truth.empty();
  const std::vector<std::size_t> plotted = plotted_frames(run, plot_limit(run.parts.size(), has_truth));
  Json json;
  json["generator"] = std::string("cylpose ") + kVersion;
  json["title"] = report.title;
  json["frames_in_all"] = run.frames.size();
  json["frame"] = column(plotted, [&](std::size_t i) { return run.frames[i]; });
  json["timestamp_s"] = column_of(plotted, run.timestamp_s, [](double seconds) { return seconds; });
  if (!report.frame_times.empty()) json["frame_ms"] = times_json(report, run, plotted);
  json["parts"] = Json::array();
  for (const PartSeries& part : run.parts) json["parts"].push_back(part_json(part, plotted, has_truth));
  return html_data_block(json.dump(-1, ' ', true, Json::error_handler_t::replace));
}

}  // namespace cylpose
