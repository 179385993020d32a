// The report's numbers as JSON.
#pragma once

#include <string>

#include "series.hpp"

namespace cylpose {

/// One JSON object that may stand inside a <script> element whatever the texts in it are. docs/report.md describes it.
[[nodiscard]] std::string data_block(const Report& report, const RunSeries& run);

/// `text` as valid UTF-8, bytes that are not replaced by U+FFFD.
[[nodiscard]] std::string valid_utf8(const std::string& text);

}  // namespace cylpose
