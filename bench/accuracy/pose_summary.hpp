// Outcomes summed up in cells, as tables for people and machines.
#pragma once

#include <cylpose/evaluate.hpp>
#include <filesystem>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "consistency.hpp"
#include "pose_outcome.hpp"

namespace cylpose::bench {

/// Errors over those that were found, wrong poses included.
struct Cell {
  std::string name;
  int count = 0;
  int found = 0;
  int wrong = 0;
  std::optional<Statistics> center_m, depth_m, lateral_m, along_axis_m, axis_deg;
  std::optional<double> center_share;  ///< median of centre error / distance
  /// Median of error / standard deviation at the bound, over the outcomes with a bound. About 0.7 for an estimate at
  /// the bound: the median of a normal variable's absolute value is 0.674 sigma.
  std::optional<double> center_to_bound, axis_to_bound;
  /// Mean of the signed depth error / its standard deviation at the bound, where the centre is within 20 of these.
  /// Without bias it is within 2 / sqrt(count) of 0 in 95 of 100 cells.
  std::optional<double> depth_bias;
  int biased_count = 0;  ///< outcomes behind `depth_bias`
  std::optional<double> nees_mean, nees_median;
  std::optional<Band> nees_band;      ///< 95 %, of the mean
  std::optional<double> nees_inside;  ///< share of the outcomes below the 95 % quantile of one
  int nees_count = 0;                 ///< outcomes behind these
};

[[nodiscard]] Cell cell_of(std::string name, std::span<const Outcome* const> outcomes);

using Filter = std::function<bool(const Outcome&)>;
using KeyOf = std::function<std::string(const Outcome&)>;

[[nodiscard]] std::vector<const Outcome*> chosen(std::span<const Outcome> outcomes, const Filter& filter);

/// One cell for each key, in the order of the keys.
[[nodiscard]] std::vector<Cell> cells_by(std::span<const Outcome* const> outcomes, const KeyOf& key);

struct PoseTable {
  std::string title;
  std::vector<Cell> cells;
};

/// The tables of the groups that there are.
[[nodiscard]] std::vector<PoseTable> pose_tables(std::span<const Outcome> outcomes);

/// Millimetres and degrees; medians (95th percentiles).
[[nodiscard]] std::string text_of(const PoseTable& table);

/// One JSON object per table; metres and degrees; null where there is no value.
[[nodiscard]] std::string json_of(std::span<const PoseTable> tables);

/// One row per outcome; metres and degrees; empty where there is no value.
[[nodiscard]] std::string csv_of(std::span<const Outcome> outcomes);

}  // namespace cylpose::bench
