// The figures that table and page of a run share.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "case_grid.hpp"

namespace cylpose::bench {

/// The backend that the others are compared with.
inline constexpr std::string_view kYardstick = "opencl";

/// Milliseconds; none for null.
[[nodiscard]] std::optional<double> median_time(const Measured* benchmark);

/// Milliseconds in which this machine could read the searched pixels once, at the bandwidth of this frame size; none
/// where the run did not measure it.
[[nodiscard]] std::optional<double> read_time(const BenchRun& run, const CaseRow& row);

/// How many times longer each backend took than the yardstick, in the order of the backends; none where either did not
/// run. Empty for a grid without the yardstick.
[[nodiscard]] std::vector<std::optional<double>> ratios(const CaseGrid& grid, const CaseRow& row);

/// All stages of the grids, in the order of their first appearance.
[[nodiscard]] std::vector<std::string> stage_names(const std::vector<CaseGrid>& grids);

/// Whether a key of BenchRun::context says on what was measured, and not how the file came about.
[[nodiscard]] bool is_of_machine(std::string_view key);

/// "-" for none.
[[nodiscard]] std::string number_text(std::optional<double> value, int decimals);

}  // namespace cylpose::bench
