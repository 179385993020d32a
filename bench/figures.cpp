#include "figures.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>

namespace cylpose::bench {

std::optional<double> median_time(const Measured* benchmark) {
  return benchmark == nullptr ? std::nullopt : std::optional(median(benchmark->milliseconds));
}

std::optional<double> read_time(const BenchRun& run, const CaseRow& row) {
  const Measured* bandwidth = run.find("read_bandwidth/" + row.size);
  const auto any = std::ranges::find_if(row.by_backend, [](const Measured* cell) { return cell != nullptr; });
  if (bandwidth == nullptr || any == row.by_backend.end()) return std::nullopt;
  const std::optional<double> bytes = median_counter(**any, "frame_bytes");
  const std::optional<double> rate = median_counter(*bandwidth, "GB/s");
  return bytes && rate ? std::optional(*bytes / *rate * 1e-6) : std::nullopt;
}

std::vector<std::optional<double>> ratios(const CaseGrid& grid, const CaseRow& row) {
  const auto yardstick = std::ranges::find(grid.backends, kYardstick);
  std::vector<std::optional<double>> result;
  if (yardstick == grid.backends.end()) return result;
  const auto reference = median_time(row.by_backend[static_cast<std::size_t>(yardstick - grid.backends.begin())]);
  for (const Measured* cell : row.by_backend) {
    const auto time = median_time(cell);
    result.push_back(time && reference ? std::optional(*time / *reference) : std::nullopt);
  }
  return result;
}

std::vector<std::string> stage_names(const std::vector<CaseGrid>& grids) {
  std::vector<std::string> names;
  for (const CaseGrid& grid : grids) {
    for (const CaseRow& row : grid.rows) {
      for (const Measured* cell : row.by_backend) {
        if (cell == nullptr) continue;
        for (const Stage& stage : stages_of(*cell)) {
          if (std::ranges::find(names, stage.name) == names.end()) names.push_back(stage.name);
        }
      }
    }
  }
  return names;
}

bool is_of_machine(std::string_view key) {
  return key != "host_name" && key != "executable" && key != "library_build_type";
}

std::string number_text(std::optional<double> value, int decimals) {
  return value ? fmt::format("{:.{}f}", *value, decimals) : "-";
}

}  // namespace cylpose::bench
