// The benchmarks of the form <kind>/<backend>/<scene>/<size>, put side by side for comparison.
#pragma once

#include <string>
#include <vector>

#include "results.hpp"

namespace cylpose::bench {

/// One scene at one size, by all backends.
struct CaseRow {
  std::string scene;
  std::string size;
  std::vector<const Measured*> by_backend;  ///< in the order of CaseGrid::backends; null where it did not run
};

struct CaseGrid {
  std::string kind;
  std::vector<std::string> backends;  ///< in order of first appearance
  std::vector<CaseRow> rows;
};

/// Scene by scene, sizes in the order of their area. The run must outlive the grid.
[[nodiscard]] CaseGrid grid_of(const BenchRun& run, const std::string& kind);

}  // namespace cylpose::bench
