#include "requirements.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cylpose/evaluate.hpp>
#include <limits>

#include "consistency.hpp"
#include "pose_summary.hpp"

namespace cylpose::bench {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kMillimetre = 1000;

class Judge {
 public:
  explicit Judge(std::span<const Outcome> outcomes) : outcomes_(outcomes) {}

  // The value that `of` finds in the cell of the chosen outcomes; none of it where nothing was chosen.
  template <typename Value>
  void add(const std::string& name, const Filter& filter, const Value& of, double low, double high,
           const std::string& unit) {
    const auto members = chosen(outcomes_, [&](const Outcome& o) { return o.method != "thesis" && filter(o); });
    if (members.empty()) return;
    const std::optional<double> value = of(cell_of(name, members));
    requirements_.push_back({name, value.value_or(std::numeric_limits<double>::quiet_NaN()), low, high, unit});
  }

  std::vector<Requirement> requirements_;

 private:
  std::span<const Outcome> outcomes_;
};

bool is_random(const Outcome& o) {
  return o.group == "random" && o.variant == kNominal;
}

Filter open_at(double distance_m) {
  return [=](const Outcome& o) {
    return is_random(o) && o.occlusion_percent == 0 && o.tilt_deg >= 30 && std::abs(o.distance_m - distance_m) < 0.01;
  };
}

Filter frames_of(const std::string& scenario) {
  return [=](const Outcome& o) { return o.scenario == scenario; };
}

std::optional<double> found_percent(const Cell& cell) {
  return 100.0 * cell.found / cell.count;
}

std::optional<double> wrong_count(const Cell& cell) {
  return cell.wrong;
}

template <double Statistics::*Which>
auto center_mm() {
  return [](const Cell& c) { return c.center_m ? std::optional(kMillimetre * (*c.center_m).*Which) : std::nullopt; };
}

template <double Statistics::*Which>
auto axis_deg() {
  return [](const Cell& c) { return c.axis_deg ? std::optional((*c.axis_deg).*Which) : std::nullopt; };
}

// A staircase shows in how the depth's error changes from frame to frame and back: the second differences' median size
// as a multiple of what independent errors at the bound would have.
std::optional<double> roughness(std::span<const Outcome> outcomes) {
  std::vector<const Outcome*> frames =
      chosen(outcomes, [](const Outcome& o) { return o.scenario == "series1" && o.method != "thesis"; });
  std::ranges::sort(frames, {}, [](const Outcome* o) { return o->trial; });
  std::vector<double> ratios;
  for (std::size_t i = 2; i < frames.size(); ++i) {
    const Outcome& a = *frames[i - 2];
    const Outcome& b = *frames[i - 1];
    const Outcome& c = *frames[i];
    if (!a.found || !b.found || !c.found || !b.bound) continue;
    const double second = a.depth_error_m - 2 * b.depth_error_m + c.depth_error_m;
    ratios.push_back(std::abs(second) / (0.674 * std::sqrt(6.0) * b.bound->depth_m));
  }
  const auto statistics = statistics_of(ratios);
  return statistics ? std::optional(statistics->median) : std::nullopt;
}

}  // namespace

std::vector<Requirement> location_requirements(std::span<const Location> locations) {
  double with_channel = 0;
  double without = 0;
  std::vector<Requirement> requirements;
  for (const Location& location : locations) {
    double& bias = location.null_channel ? with_channel : without;
    bias = std::max(bias, location.mean_abs_bias_px);
  }
  if (locations.empty()) return requirements;
  requirements.push_back({"edges: mean |bias|, worst case with a null channel", with_channel, 0, 0.02, "px"});
  requirements.push_back({"edges: mean |bias|, worst case without", without, 0, 0.1, "px"});
  for (const Location& location : locations) {
    if (location.level == "black") {
      requirements.push_back(
          {"edges: mean |bias| before black, else as usual", location.mean_abs_bias_px, 0, 0.1, "px"});
    }
    if (location.factor != kUsual) continue;
    requirements.push_back(
        {"edges: mean |bias|, contrast 100, noise 2, blur 0.8", location.mean_abs_bias_px, 0, 0.02, "px"});
    requirements.push_back(
        {"edges: sigma / bound, contrast 100, noise 2, blur 0.8", location.sigma_px / location.bound_px, 0, 1.5, ""});
  }
  return requirements;
}

std::vector<Requirement> pose_requirements(std::span<const Outcome> outcomes) {
  Judge judge(outcomes);
  const auto share = [](const Cell& c) { return c.center_share ? std::optional(100 * *c.center_share) : std::nullopt; };
  for (const auto& [distance_m, limit] : {std::pair(5.0, 0.3), {3.0, 0.1}, {1.5, 0.03}, {1.0, 0.03}}) {
    judge.add(fmt::format("centre, median, {:g} m", distance_m), open_at(distance_m), share, 0, limit, "% of distance");
    const Filter bound_above_limit = [distance_m = distance_m, limit = limit](const Outcome& o) {
      return open_at(distance_m)(o) && o.bound && 100 * o.bound->center_m > limit * o.distance_m;
    };
    judge.add(
        fmt::format("centre, median / bound, {:g} m, where that is above {:g} %", distance_m, limit), bound_above_limit,
        [](const Cell& c) { return c.center_to_bound; }, 0, 2, "");
  }
  judge.add("axis, median, 5 m", open_at(5), axis_deg<&Statistics::median>(), 0, 1, "deg");
  if (const auto value = roughness(outcomes)) {
    judge.requirements_.push_back({"series1: second differences of depth / bound's", *value, 0, 2, ""});
  }
  judge.add("series4: centre, median", frames_of("series4"), center_mm<&Statistics::median>(), 0, 0.5, "mm");
  judge.add("series4: centre, 95th percentile", frames_of("series4"), center_mm<&Statistics::p95>(), 0, 1, "mm");
  judge.add("series4: axis, median", frames_of("series4"), axis_deg<&Statistics::median>(), 0, 0.02, "deg");
  const Filter candle = [](const Outcome& o) { return o.scenario == "candle" && o.distance_m > 1.05; };
  judge.add("candle at 1.1 m: centre, 95th percentile", candle, center_mm<&Statistics::p95>(), 0, 0.4, "mm");
  judge.add("candle at 1.1 m: axis, 95th percentile", candle, axis_deg<&Statistics::p95>(), 0, 0.39, "deg");
  for (const auto& [percent, least] : {std::pair(0, 100.0), {25, 99.0}, {50, 90.0}}) {
    const Filter hidden = [percent = percent](const Outcome& o) {
      return is_random(o) && o.tilt_deg >= 30 && o.occlusion_percent == percent;
    };
    judge.add(fmt::format("{} % hidden: found", percent), hidden, found_percent, least, 100, "%");
    judge.add(fmt::format("{} % hidden: wrong", percent), hidden, wrong_count, 0, 0, "");
  }
  const Filter along_axis = [](const Outcome& o) {
    return is_random(o) && o.tilt_deg < 28 && o.occlusion_percent == 0;
  };
  judge.add("along the axis (tilt below 28 deg): found", along_axis, found_percent, 95, 100, "%");
  judge.add("along the axis (tilt below 28 deg): wrong", along_axis, wrong_count, 0, 0, "");
  judge.add("random scenes: wrong", is_random, wrong_count, 0, 0, "");
  judge.add(
      "random scenes, all noise and blur: wrong", [](const Outcome& o) { return o.group == "random"; }, wrong_count, 0,
      0, "");
  judge.add(
      "beyond what is modelled: wrong", [](const Outcome& o) { return o.group == "beyond"; }, wrong_count, 0, 0, "");
  judge.add(
      "scenarios: wrong", [](const Outcome& o) { return o.group == "scenario"; }, wrong_count, 0, 0, "");
  const auto poses = chosen(outcomes, [](const Outcome& o) { return is_random(o) && o.nees; });
  if (!poses.empty()) {
    const Band band = mean_nees_band(static_cast<int>(poses.size()));
    judge.add(
        "random scenes: mean NEES", is_random, [](const Cell& c) { return c.nees_mean; }, band.low, band.high, "");
    judge.add(
        "random scenes: frames below the 95 % quantile", is_random,
        [](const Cell& c) { return c.nees_inside ? std::optional(100 * *c.nees_inside) : std::nullopt; }, 95, 100, "%");
    judge.add(
        "random scenes: |mean depth error| / bound's sigma", is_random,
        [](const Cell& c) { return c.depth_bias ? std::optional(std::abs(*c.depth_bias)) : std::nullopt; }, 0, 0.5, "");
  }
  return std::move(judge.requirements_);
}

std::string text_of(std::span<const Requirement> requirements) {
  std::string text;
  for (const Requirement& r : requirements) {
    const std::string limit = r.high == kInfinity ? fmt::format(">= {:g}", r.low)
                              : r.low > 0         ? fmt::format("{:.3g} to {:.3g}", r.low, r.high)
                                                  : fmt::format("<= {:g}", r.high);
    text += fmt::format("{:<8}{:<58}{:>12.4g} {:<14} ({})\n", r.is_met() ? "met" : "NOT MET", r.name, r.measured,
                        r.unit, limit);
  }
  return text;
}

}  // namespace cylpose::bench
