// What of a report is text: tables that read without scripts.
#pragma once

#include <string>

#include "series.hpp"

namespace cylpose {

/// Found, predicted, none, errors: one column per part.
[[nodiscard]] std::string summary_html(const RunSeries& run);
/// Errors, residuals and stated uncertainty of one part, and why it was not found.
[[nodiscard]] std::string part_html(const PartSeries& part);
[[nodiscard]] std::string stages_html(const std::vector<StageSummary>& stages);
[[nodiscard]] std::string pictures_html(const std::vector<ReportPicture>& pictures);

}  // namespace cylpose
