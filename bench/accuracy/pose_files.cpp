// Outcomes and tables for machines.
#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <string>

#include "pose_summary.hpp"

namespace cylpose::bench {
namespace {

using nlohmann::json;

json json_of(const std::optional<double>& value) {
  return value ? json(*value) : json(nullptr);
}

json json_of(const std::optional<Statistics>& s) {
  if (!s) return nullptr;
  return {{"mean", s->mean}, {"median", s->median}, {"p95", s->p95}, {"max", s->max}};
}

json json_of(const Cell& cell) {
  return {{"name", cell.name},
          {"count", cell.count},
          {"found", cell.found},
          {"wrong", cell.wrong},
          {"center_m", json_of(cell.center_m)},
          {"depth_m", json_of(cell.depth_m)},
          {"lateral_m", json_of(cell.lateral_m)},
          {"along_axis_m", json_of(cell.along_axis_m)},
          {"axis_deg", json_of(cell.axis_deg)},
          {"center_share", json_of(cell.center_share)},
          {"center_to_bound", json_of(cell.center_to_bound)},
          {"axis_to_bound", json_of(cell.axis_to_bound)},
          {"depth_bias", json_of(cell.depth_bias)},
          {"nees_mean", json_of(cell.nees_mean)},
          {"nees_band", cell.nees_band ? json{cell.nees_band->low, cell.nees_band->high} : json(nullptr)},
          {"nees_median", json_of(cell.nees_median)},
          {"nees_inside", json_of(cell.nees_inside)}};
}

std::string number(const std::optional<double>& value) {
  return value ? fmt::format("{:.9g}", *value) : "";
}

}  // namespace

std::string json_of(std::span<const PoseTable> tables) {
  json all = json::array();
  for (const PoseTable& table : tables) {
    json cells = json::array();
    for (const Cell& cell : table.cells) cells.push_back(json_of(cell));
    all.push_back({{"title", table.title}, {"cells", cells}});
  }
  return all.dump(1) + "\n";
}

std::string csv_of(std::span<const Outcome> outcomes) {
  std::string csv =
      "group,scenario,variant,method,trial,distance_m,tilt_deg,occlusion_percent,noise_sigma,blur_sigma_px,found,wrong,"
      "center_m,depth_m,lateral_m,along_axis_m,axis_deg,depth_signed_m,sigma_depth_m,nees,bound_center_m,bound_depth_m,"
      "bound_axis_deg,edge_sigma_px,rms_px,seen,reason\n";
  for (const Outcome& o : outcomes) {
    const auto found = [&](double value) { return number(o.found ? std::optional(value) : std::nullopt); };
    const auto bound = [&](double SceneBound::*member) {
      return number(o.bound ? std::optional((*o.bound).*member) : std::nullopt);
    };
    csv += fmt::format(
        "{},{},{},{},{},{:.6g},{:.6g},{},{:g},{:g},{},{},{},{},{},{},{},{},{},{},{},{},{},{:.4g},{},{},\"{}\"\n",
        o.group, o.scenario, o.variant, o.method, o.trial, o.distance_m, o.tilt_deg, o.occlusion_percent, o.noise_sigma,
        o.blur_sigma_px, o.found ? 1 : 0, o.wrong ? 1 : 0, found(o.error.position_m), found(o.error.depth_m),
        found(o.error.lateral_m), found(o.error.along_axis_m), found(o.error.axis_angle_deg), found(o.depth_error_m),
        found(o.sigma_depth_m), number(o.nees), bound(&SceneBound::center_m), bound(&SceneBound::depth_m),
        bound(&SceneBound::axis_deg), o.edge_sigma_px, found(o.rms_px), found(o.seen), o.reason);
  }
  return csv;
}

}  // namespace cylpose::bench
