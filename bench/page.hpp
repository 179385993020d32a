// A run as one HTML page that needs nothing else.
#pragma once

#include <string>

#include "results.hpp"

namespace cylpose::bench {

/// Times of all backends side by side, with ratios and as bars of their stages; what remains as a table; the numbers as
/// JSON in `<script id="data">` (docs/bench.md).
[[nodiscard]] std::string page_of(const BenchRun& run);

}  // namespace cylpose::bench
