#include "table.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <optional>
#include <string_view>

#include "case_grid.hpp"

namespace cylpose::bench {
namespace {

// What the others are compared with.
constexpr std::string_view kYardstick = "opencl";

std::string machine(const BenchRun& run) {
  std::string text;
  for (const auto& [key, value] : run.context) {
    if (key == "host_name" || key == "executable" || key == "library_build_type") continue;
    text += fmt::format("{:<16}  {}\n", key, value);
  }
  return text;
}

std::string number(std::optional<double> value, int decimals) {
  return value ? fmt::format("{:.{}f}", *value, decimals) : "-";
}

std::optional<double> median_time(const Measured* benchmark) {
  return benchmark == nullptr ? std::nullopt : std::optional(median(benchmark->milliseconds));
}

// The searched pixels at the bandwidth of this frame size.
std::optional<double> read_time(const BenchRun& run, const CaseRow& row) {
  const Measured* bandwidth = run.find("read_bandwidth/" + row.size);
  const auto any = std::ranges::find_if(row.by_backend, [](const Measured* cell) { return cell != nullptr; });
  if (bandwidth == nullptr || any == row.by_backend.end()) return std::nullopt;
  const std::optional<double> bytes = median_counter(**any, "frame_bytes");
  const std::optional<double> rate = median_counter(*bandwidth, "GB/s");
  return bytes && rate ? std::optional(*bytes / *rate * 1e-6) : std::nullopt;
}

std::string times(const BenchRun& run, const CaseGrid& grid) {
  if (grid.rows.empty()) return {};
  const auto yardstick = std::ranges::find(grid.backends, kYardstick);
  const auto column = static_cast<std::size_t>(yardstick - grid.backends.begin());
  std::string text = fmt::format("\n{:<10}{:>11}", grid.kind, "median ms");
  for (const std::string& backend : grid.backends) text += fmt::format("{:>10}", backend);
  text += fmt::format("{:>10}", "reading");
  if (yardstick != grid.backends.end()) {
    for (const std::string& backend : grid.backends) {
      if (backend != kYardstick) text += fmt::format("{:>16}", fmt::format("{}/{}", backend, kYardstick));
    }
  }
  text += '\n';
  for (const CaseRow& row : grid.rows) {
    text += fmt::format("{:<10}{:>11}", row.scene, row.size);
    for (const Measured* cell : row.by_backend) text += fmt::format("{:>10}", number(median_time(cell), 3));
    text += fmt::format("{:>10}", number(read_time(run, row), 4));
    if (yardstick != grid.backends.end()) {
      const std::optional<double> reference = median_time(row.by_backend[column]);
      for (std::size_t i = 0; i < grid.backends.size(); ++i) {
        if (i == column) continue;
        const std::optional<double> time = median_time(row.by_backend[i]);
        text += fmt::format("{:>16}", number(time && reference ? std::optional(*time / *reference) : std::nullopt, 1));
      }
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
      text += fmt::format("{:<10}{:>11}{:>10}{:>12}{:>12}{:>10}\n", row.scene, row.size, grid.backends[i],
                          number(median_counter(*cell, "frames/s"), 1), number(median_counter(*cell, "Mpixel/s"), 1),
                          number(median_counter(*cell, "GB/s"), 2));
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
    text += fmt::format("{:<30}{:>12}{:>10}\n", benchmark.name, number(median_time(&benchmark), 4), number(rate, 1));
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
