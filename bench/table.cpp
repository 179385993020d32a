#include "table.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <optional>
#include <vector>

#include "figures.hpp"

namespace cylpose::bench {
namespace {

std::string machine(const BenchRun& run) {
  std::string text;
  for (const auto& [key, value] : run.context) {
    if (is_of_machine(key)) text += fmt::format("{:<16}  {}\n", key, value);
  }
  return text;
}

std::string times(const BenchRun& run, const CaseGrid& grid) {
  if (grid.rows.empty()) return {};
  const bool compared = std::ranges::find(grid.backends, kYardstick) != grid.backends.end();
  std::string text = fmt::format("\n{:<10}{:>11}", grid.kind, "median ms");
  for (const std::string& backend : grid.backends) text += fmt::format("{:>10}", backend);
  text += fmt::format("{:>10}", "reading");
  for (const std::string& backend : grid.backends) {
    if (compared && backend != kYardstick) text += fmt::format("{:>16}", fmt::format("{}/{}", backend, kYardstick));
  }
  text += '\n';
  for (const CaseRow& row : grid.rows) {
    text += fmt::format("{:<10}{:>11}", row.scene, row.size);
    for (const Measured* cell : row.by_backend) text += fmt::format("{:>10}", number_text(median_time(cell), 3));
    text += fmt::format("{:>10}", number_text(read_time(run, row), 4));
    const std::vector<std::optional<double>> all = ratios(grid, row);
    for (std::size_t i = 0; i < all.size(); ++i) {
      if (grid.backends[i] != kYardstick) text += fmt::format("{:>16}", number_text(all[i], 1));
    }
    text += '\n';
  }
  return text;
}

std::string throughput(const CaseGrid& grid) {
  if (grid.rows.empty()) return {};
  std::string text = fmt::format("\n{:<10}{:>11}{:>10}{:>12}{:>12}{:>10}\n", grid.kind, "throughput", "backend",
                                 "frames/s", "Mpixel/s", "GB/s");
  for (const CaseRow& row : grid.rows) {
    for (std::size_t i = 0; i < grid.backends.size(); ++i) {
      const Measured* cell = row.by_backend[i];
      if (cell == nullptr) continue;
      text +=
          fmt::format("{:<10}{:>11}{:>10}{:>12}{:>12}{:>10}\n", row.scene, row.size, grid.backends[i],
                      number_text(median_counter(*cell, "frames/s"), 1),
                      number_text(median_counter(*cell, "Mpixel/s"), 1), number_text(median_counter(*cell, "GB/s"), 2));
    }
  }
  return text;
}

std::string stages(const CaseGrid& grid) {
  if (grid.rows.empty()) return {};
  std::string text = fmt::format("\n{:<10}{:>11}{:>10}  milliseconds in each stage\n", grid.kind, "stages", "backend");
  for (const CaseRow& row : grid.rows) {
    for (std::size_t i = 0; i < grid.backends.size(); ++i) {
      if (row.by_backend[i] == nullptr) continue;
      text += fmt::format("{:<10}{:>11}{:>10} ", row.scene, row.size, grid.backends[i]);
      for (const Stage& stage : stages_of(*row.by_backend[i])) {
        text += fmt::format(" {} {:.3f}", stage.name, stage.milliseconds);
      }
      text += '\n';
    }
  }
  return text;
}

std::string others(const BenchRun& run) {
  std::string text;
  for (const Measured& benchmark : run.benchmarks) {
    if (parsed_case(benchmark.name)) continue;
    const std::optional<double> rate = median_counter(benchmark, "GB/s");
    text += fmt::format("{:<30}{:>12}{:>10}\n", benchmark.name, number_text(median_time(&benchmark), 4),
                        number_text(rate, 1));
  }
  return text.empty() ? text : fmt::format("\n{:<30}{:>12}{:>10}\n", "others", "median ms", "GB/s") + text;
}

}  // namespace

std::string table_of(const BenchRun& run) {
  const CaseGrid detect = grid_of(run, "detect");
  const CaseGrid estimate = grid_of(run, "estimate");
  return machine(run) + times(run, detect) + times(run, estimate) + others(run) + throughput(detect) + stages(detect) +
         stages(estimate);
}

}  // namespace cylpose::bench
