// Two revisions, measured in turn.
#pragma once

#include <string>
#include <vector>

#include "results.hpp"

namespace cylpose::bench {

/// One benchmark under both revisions, milliseconds.
struct Change {
  std::string name;
  double old_median = 0;
  double old_worst = 0;
  double new_median = 0;
  double new_best = 0;

  /// Even the best new run took longer than the worst old one: no luck with a busy machine explains that.
  [[nodiscard]] bool is_slower() const { return new_best > old_worst; }
};

/// The benchmarks that both sides have; all runs and repetitions of a side count.
[[nodiscard]] std::vector<Change> changes(const std::vector<BenchRun>& old_runs, const std::vector<BenchRun>& new_runs);

[[nodiscard]] std::string text_of(const std::vector<Change>& changes);

}  // namespace cylpose::bench
