#include "case_grid.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdlib>
#include <tuple>

namespace cylpose::bench {
namespace {

template <typename T>
std::size_t place_of(const std::vector<T>& list, const T& wanted) {
  return static_cast<std::size_t>(std::ranges::find(list, wanted) - list.begin());
}

// Pixels of a size such as "1280x720"; 0 for another text.
long area(const std::string& size) {
  char* end = nullptr;
  const long width = std::strtol(size.c_str(), &end, 10);
  return *end == 'x' ? width * std::strtol(end + 1, nullptr, 10) : 0;
}

CaseRow& row_of(CaseGrid& grid, const CaseName& name) {
  const auto known = std::ranges::find_if(
      grid.rows, [&](const CaseRow& row) { return row.scene == name.scene && row.size == name.size; });
  if (known != grid.rows.end()) return *known;
  return grid.rows.emplace_back(CaseRow{name.scene, name.size, {}});
}

}  // namespace

CaseGrid grid_of(const BenchRun& run, const std::string& kind) {
  CaseGrid grid;
  grid.kind = kind;
  for (const Measured& benchmark : run.benchmarks) {
    const std::optional<CaseName> name = parsed_case(benchmark.name);
    if (!name || name->kind != kind) continue;
    const std::size_t column = place_of(grid.backends, name->backend);
    if (column == grid.backends.size()) grid.backends.push_back(name->backend);
    std::vector<const Measured*>& cells = row_of(grid, *name).by_backend;
    cells.resize(std::max(cells.size(), column + 1));
    cells[column] = &benchmark;
  }
  for (CaseRow& row : grid.rows) row.by_backend.resize(grid.backends.size());
  std::ranges::stable_sort(grid.rows, {}, [](const CaseRow& row) { return std::tuple(row.scene, area(row.size)); });
  return grid;
}

}  // namespace cylpose::bench
