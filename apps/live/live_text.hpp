// What viewers get to read: JSON for the page, and metrics for Prometheus.
#pragma once

#include <cylpose/report.hpp>
#include <string>
#include <vector>

#include "live_state.hpp"

namespace cylpose::apps {

/// One line of JSON (docs/live.md names the keys). Numbers that are not finite and what is not known are null, text
/// that is not UTF-8 is replaced.
[[nodiscard]] std::string to_json(const LiveView& view, const std::vector<ReportFact>& facts);

/// The Prometheus text exposition format, version 0.0.4.
[[nodiscard]] std::string to_metrics(const LiveView& view);

}  // namespace cylpose::apps
