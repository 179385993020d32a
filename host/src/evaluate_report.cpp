#include <fmt/format.h>

#include <cylpose/evaluate.hpp>
#include <nlohmann/json.hpp>

namespace cylpose {
namespace {

nlohmann::ordered_json json_of(const std::optional<Statistics>& statistics) {
  if (!statistics) return nullptr;
  return {
      {"mean", statistics->mean}, {"median", statistics->median}, {"p95", statistics->p95}, {"max", statistics->max}};
}

std::string table_row(const char* label, const std::optional<Statistics>& statistics, double factor) {
  if (!statistics) return fmt::format("{:<26}{:>11}{:>11}{:>11}{:>11}\n", label, "-", "-", "-", "-");
  return fmt::format("{:<26}{:>11.4f}{:>11.4f}{:>11.4f}{:>11.4f}\n", label, factor * statistics->mean,
                     factor * statistics->median, factor * statistics->p95, factor * statistics->max);
}

}  // namespace

std::string to_text(const Evaluation& evaluation) {
  constexpr double kMillimetres = 1000;
  std::string text = fmt::format("found      {} of {} ({:.1f} %); predicted {}, none {}, missing {}\n", evaluation.ok,
                                 evaluation.expected, 100 * evaluation.found_rate(), evaluation.predicted,
                                 evaluation.none, evaluation.missing);
  text += fmt::format("wrong      {} (ok, but the axis off by more than {} deg)\n", evaluation.wrong,
                      evaluation.wrong_axis_deg);
  text += fmt::format("\n{:<26}{:>11}{:>11}{:>11}{:>11}\n", "error of the ok poses", "mean", "median", "p95", "max");
  text += table_row("centre, whole       [mm]", evaluation.position_m, kMillimetres);
  text += table_row("  depth             [mm]", evaluation.depth_m, kMillimetres);
  text += table_row("  lateral           [mm]", evaluation.lateral_m, kMillimetres);
  text += table_row("  along the axis    [mm]", evaluation.along_axis_m, kMillimetres);
  text += table_row("axis line distance  [mm]", evaluation.axis_line_m, kMillimetres);
  text += table_row("axis angle         [deg]", evaluation.axis_angle_deg, 1);
  if (evaluation.position_m) {
    text += fmt::format("\nmean position error (thesis, equation 5.4): {:.6f} m\n", evaluation.position_m->mean);
  }
  return text;
}

std::string to_json(const Evaluation& evaluation) {
  nlohmann::ordered_json json;
  json["expected"] = evaluation.expected;
  json["ok"] = evaluation.ok;
  json["predicted"] = evaluation.predicted;
  json["none"] = evaluation.none;
  json["missing"] = evaluation.missing;
  json["surplus"] = evaluation.surplus;
  json["found_rate"] = evaluation.found_rate();
  json["wrong"] = evaluation.wrong;
  json["wrong_axis_deg"] = evaluation.wrong_axis_deg;
  json["mean_position_error_m"] = evaluation.position_m ? nlohmann::ordered_json(evaluation.position_m->mean) : nullptr;
  json["position_m"] = json_of(evaluation.position_m);
  json["depth_m"] = json_of(evaluation.depth_m);
  json["lateral_m"] = json_of(evaluation.lateral_m);
  json["along_axis_m"] = json_of(evaluation.along_axis_m);
  json["axis_line_m"] = json_of(evaluation.axis_line_m);
  json["axis_angle_deg"] = json_of(evaluation.axis_angle_deg);
  return json.dump(2) + "\n";
}

}  // namespace cylpose
