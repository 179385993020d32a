#include "pose_summary.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <utility>

namespace cylpose::bench {
namespace {

// Farther off, an outcome tells of a wrong hypothesis and not of bias.
constexpr double kBiasWithinSigmas = 20;

template <typename Value>
std::vector<double> values_of(std::span<const Outcome* const> outcomes, const Value& value) {
  std::vector<double> values;
  for (const Outcome* outcome : outcomes) {
    if (const std::optional<double> one = value(*outcome)) values.push_back(*one);
  }
  return values;
}

std::optional<double> median_of(std::vector<double> values) {
  const auto statistics = statistics_of(std::move(values));
  return statistics ? std::optional(statistics->median) : std::nullopt;
}

void sum_up_nees(std::span<const Outcome* const> outcomes, Cell* cell) {
  const std::vector<double> nees = values_of(outcomes, [](const Outcome& o) { return o.nees; });
  if (nees.empty()) return;
  cell->nees_count = static_cast<int>(nees.size());
  cell->nees_band = mean_nees_band(cell->nees_count);
  const double limit = chi_squared_quantile(0.95, kDegreesOfFreedom);
  cell->nees_inside = static_cast<double>(std::ranges::count_if(nees, [&](double n) { return n <= limit; })) /
                      static_cast<double>(nees.size());
  std::vector<double> finite;
  std::ranges::copy_if(nees, std::back_inserter(finite), [](double n) { return std::isfinite(n); });
  if (finite.size() < nees.size()) return;  // a covariance that is none has no mean
  const auto statistics = statistics_of(finite);
  cell->nees_mean = statistics->mean;
  cell->nees_median = statistics->median;
}

void sum_up_bound(std::span<const Outcome* const> found, Cell* cell) {
  const auto ratio = [](const auto& of) {
    return [of](const Outcome& o) { return o.bound ? std::optional<double>(of(o)) : std::nullopt; };
  };
  cell->center_to_bound =
      median_of(values_of(found, ratio([](const Outcome& o) { return o.error.position_m / o.bound->center_m; })));
  cell->axis_to_bound =
      median_of(values_of(found, ratio([](const Outcome& o) { return o.error.axis_angle_deg / o.bound->axis_deg; })));
  std::vector<double> depths =
      values_of(found, ratio([](const Outcome& o) { return o.depth_error_m / o.bound->depth_m; }));
  std::erase_if(depths, [](double d) { return std::abs(d) > kBiasWithinSigmas; });
  cell->biased_count = static_cast<int>(depths.size());
  if (const auto statistics = statistics_of(depths)) cell->depth_bias = statistics->mean;
}

// "-" where there is no value.
std::string shown(const std::optional<double>& value, const char* format, double scale = 1) {
  return value ? fmt::format(fmt::runtime(format), scale * *value) : "-";
}

std::string shown(const std::optional<Statistics>& statistics, double scale) {
  if (!statistics) return "-";
  return fmt::format("{:.3g} ({:.3g})", scale * statistics->median, scale * statistics->p95);
}

Filter all_of(std::vector<Filter> filters) {
  return [filters = std::move(filters)](const Outcome& o) {
    return std::ranges::all_of(filters, [&](const Filter& f) { return f(o); });
  };
}

Filter group(const std::string& name) {
  return [=](const Outcome& o) { return o.group == name; };
}

std::string with_method(const std::string& key, const Outcome& o) {
  return fmt::format("{:<28}{}", key, o.method);
}

std::string tilt_range(double tilt_deg) {
  const auto* const above = std::upper_bound(std::begin(kTiltLevels) + 1, std::end(kTiltLevels) - 1, tilt_deg);
  return fmt::format("{:02.0f}..{:02.0f} deg", *(above - 1), *above);
}

std::string distance(const Outcome& o) {
  return fmt::format("{:.3g} m", o.distance_m);
}

}  // namespace

Cell cell_of(std::string name, std::span<const Outcome* const> outcomes) {
  Cell cell;
  cell.name = std::move(name);
  cell.count = static_cast<int>(outcomes.size());
  std::vector<const Outcome*> found;
  std::ranges::copy_if(outcomes, std::back_inserter(found), [](const Outcome* o) { return o->found; });
  cell.found = static_cast<int>(found.size());
  cell.wrong = static_cast<int>(std::ranges::count_if(found, [](const Outcome* o) { return o->wrong; }));
  const auto of_error = [&](double PoseError::*member) {
    return statistics_of(values_of(found, [=](const Outcome& o) { return std::optional(o.error.*member); }));
  };
  cell.center_m = of_error(&PoseError::position_m);
  cell.depth_m = of_error(&PoseError::depth_m);
  cell.lateral_m = of_error(&PoseError::lateral_m);
  cell.along_axis_m = of_error(&PoseError::along_axis_m);
  cell.axis_deg = of_error(&PoseError::axis_angle_deg);
  cell.center_share =
      median_of(values_of(found, [](const Outcome& o) { return std::optional(o.error.position_m / o.distance_m); }));
  sum_up_bound(found, &cell);
  sum_up_nees(found, &cell);
  return cell;
}

std::vector<const Outcome*> chosen(std::span<const Outcome> outcomes, const Filter& filter) {
  std::vector<const Outcome*> result;
  for (const Outcome& outcome : outcomes) {
    if (filter(outcome)) result.push_back(&outcome);
  }
  return result;
}

std::vector<Cell> cells_by(std::span<const Outcome* const> outcomes, const KeyOf& key) {
  std::map<std::string, std::vector<const Outcome*>> by_key;
  for (const Outcome* outcome : outcomes) by_key[key(*outcome)].push_back(outcome);
  std::vector<Cell> cells;
  cells.reserve(by_key.size());
  for (const auto& [name, members] : by_key) cells.push_back(cell_of(name, members));
  return cells;
}

std::vector<PoseTable> pose_tables(std::span<const Outcome> outcomes) {
  const Filter nominal = [](const Outcome& o) { return o.variant == kNominal; };
  const Filter by_default = [](const Outcome& o) { return o.method != "thesis"; };
  const Filter open = [](const Outcome& o) { return o.occlusion_percent == 0; };
  const Filter sides_seen = [](const Outcome& o) { return o.tilt_deg >= 30; };
  const Filter random = group("random");
  std::vector<PoseTable> tables;
  const auto add = [&](const std::string& title, const Filter& filter, const KeyOf& key) {
    PoseTable table{title, cells_by(chosen(outcomes, filter), key)};
    if (!table.cells.empty()) tables.push_back(std::move(table));
  };
  add("random: all", all_of({random, nominal}), [](const Outcome& o) { return with_method("nominal", o); });
  add("random: distance, tilt 30 deg and more, nothing hidden", all_of({random, nominal, open, sides_seen}),
      [](const Outcome& o) { return with_method(distance(o), o); });
  add("random: tilt x occlusion", all_of({random, nominal}), [](const Outcome& o) {
    return with_method(fmt::format("{}, {:2} % hidden", tilt_range(o.tilt_deg), o.occlusion_percent), o);
  });
  add("random: distance x occlusion, tilt 30 deg and more", all_of({random, nominal, by_default, sides_seen}),
      [](const Outcome& o) {
        return with_method(fmt::format("{}, {:2} % hidden", distance(o), o.occlusion_percent), o);
      });
  add("random: background and light, tilt 30 deg and more", all_of({random, nominal, sides_seen}),
      [](const Outcome& o) { return with_method(o.scenario, o); });
  add("random: background x distance, tilt 30 deg and more, nothing hidden",
      all_of({random, nominal, by_default, sides_seen, open}),
      [](const Outcome& o) { return with_method(fmt::format("{}, {}", o.scenario, distance(o)), o); });
  add("random: noise and blur, tilt 30 deg and more", all_of({random, by_default, sides_seen}),
      [](const Outcome& o) { return with_method(o.variant, o); });
  add("beyond: surfaces and cameras that the method does not model", group("beyond"),
      [](const Outcome& o) { return with_method(o.variant, o); });
  add("scenarios", group("scenario"), [](const Outcome& o) { return with_method(o.scenario, o); });
  return tables;
}

std::string text_of(const PoseTable& table) {
  std::string text =
      fmt::format("{}\n{:<38}{:>5}{:>9}{:>6}{:>20}{:>8}{:>9}{:>9}{:>9}{:>18}{:>8}{:>8}{:>8}{:>10} {:<13}{:>7}{:>8}\n",
                  table.title, "", "n", "found", "wrong", "centre [mm]", "[%]", "depth", "lateral", "along",
                  "axis [deg]", "c/CRB", "a/CRB", "bias", "NEES", "[band]", "median", "inside");
  for (const Cell& c : table.cells) {
    const std::string band = c.nees_band ? fmt::format("[{:.2f}, {:.2f}]", c.nees_band->low, c.nees_band->high) : "-";
    const auto median = [](const std::optional<Statistics>& s) {
      return s ? fmt::format("{:.3g}", 1000 * s->median) : "-";
    };
    text += fmt::format(
        "{:<38}{:>5}{:>7.1f} %{:>6}{:>20}{:>8}{:>9}{:>9}{:>9}{:>18}{:>8}{:>8}{:>8}{:>10} {:<13}{:>7}{:>8}\n", c.name,
        c.count, 100.0 * c.found / c.count, c.wrong, shown(c.center_m, 1000), shown(c.center_share, "{:.3f}", 100),
        median(c.depth_m), median(c.lateral_m), median(c.along_axis_m), shown(c.axis_deg, 1),
        shown(c.center_to_bound, "{:.2f}"), shown(c.axis_to_bound, "{:.2f}"), shown(c.depth_bias, "{:+.2f}"),
        shown(c.nees_mean, "{:.4g}"), band, shown(c.nees_median, "{:.1f}"), shown(c.nees_inside, "{:.1f} %", 100));
  }
  return text;
}

}  // namespace cylpose::bench
