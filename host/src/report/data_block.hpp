// The report's numbers as JSON.
#pragma once

#include <string>

#include "series.hpp"

namespace cylpose {

/// The element that holds one JSON object. docs/report.md describes it.
[[nodiscard]] std::string data_block(const Report& report, const RunSeries& run);

}  // namespace cylpose
