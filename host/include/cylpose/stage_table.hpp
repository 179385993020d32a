// How long each stage takes, over all frames.
#pragma once

#include <cstddef>
#include <cylpose/edge_field.hpp>
#include <cylpose/evaluate.hpp>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace cylpose {

struct StageSummary {
  std::string stage;
  Statistics milliseconds;
  std::size_t frames = 0;  ///< in which the stage ran
};

class StageTable {
 public:
  /// The times of one frame; a stage that ran several times in it counts once, with the sum.
  void add(std::span<const StageTime> frame);

  /// In the order of their first appearance.
  [[nodiscard]] std::vector<StageSummary> summaries() const;

  /// Mean, median and 95th percentile of each stage in milliseconds, as a table for people.
  [[nodiscard]] std::string text() const;

 private:
  std::vector<std::pair<std::string_view, std::vector<double>>> stages_;
};

}  // namespace cylpose
