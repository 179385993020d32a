#include "opencl/results.hpp"

#include <algorithm>
#include <cstdint>
#include <numeric>

namespace cylpose::opencl {
namespace {

RegionStatistics statistics_of(std::span<const RowStatistics> rows, int first_y) {
  RegionStatistics region;
  CylU32 left = ~CylU32{0};
  CylU32 right = 0;
  int top = 0;
  int bottom = 0;
  std::int64_t y = first_y;
  for (const RowStatistics& row : rows) {
    if (row.count > 0) {
      if (region.m00 == 0) top = static_cast<int>(y);
      bottom = static_cast<int>(y) + 1;
      left = std::min(left, row.left);
      right = std::max(right, row.right);
      const std::int64_t count = row.count;
      const std::int64_t sum_x = row.sum_x;
      region.m00 += count;
      region.m10 += sum_x;
      region.m01 += count * y;
      region.m20 += static_cast<std::int64_t>(row.sum_xx);
      region.m11 += sum_x * y;
      region.m02 += count * y * y;
    }
    ++y;
  }
  if (region.m00 > 0) {
    region.box = {static_cast<int>(left), top, static_cast<int>(right - left), bottom - top};
  }
  return region;
}

EdgePixel edge_pixel(const KernelEdge& edge) {
  return {edge.x, edge.y, edge.gx, edge.gy, edge.offset_256, static_cast<EdgeStrength>(edge.kind & 3)};
}

// The kernel finds the edges of a row from left to right, but the rows in any order: a counting sort by part and row.
void sort_edges(std::span<const KernelEdge> edges, const StripTask& task, EdgeField& field) {
  const auto rows = static_cast<std::size_t>(task.search.height);
  std::vector<std::uint32_t> places(field.parts.size() * rows + 1);
  const auto row_of = [&](const KernelEdge& edge) {
    return static_cast<std::size_t>(edge.kind >> 2) * rows + static_cast<std::size_t>(edge.y - task.search.y);
  };
  for (const KernelEdge& edge : edges) ++places[row_of(edge) + 1];
  std::partial_sum(places.begin(), places.end(), places.begin());
  std::vector<std::uint32_t> first_of_part;
  for (std::size_t part = 0; part < field.parts.size(); ++part) {
    first_of_part.push_back(places[part * rows]);
    field.parts[part].edges.resize(places[(part + 1) * rows] - places[part * rows]);
  }
  for (const KernelEdge& edge : edges) {
    const std::size_t part = edge.kind >> 2;
    field.parts[part].edges[places[row_of(edge)]++ - first_of_part[part]] = edge_pixel(edge);
  }
}

Mask mask_of(const StripRun& run, const StripTask& task, std::size_t part) {
  constexpr std::uint8_t kSet = 255;
  Mask mask{task.search, {}};
  mask.pixels.reserve(static_cast<std::size_t>(task.search.width) * static_cast<std::size_t>(task.search.height));
  for (int y = 0; y < task.search.height; ++y) {
    const std::span<const CylU64> words = run.mask_row(part, y);
    for (std::size_t x = 0; x < static_cast<std::size_t>(task.search.width); ++x) {
      mask.pixels.push_back((words[x / 64] >> (x % 64) & 1) != 0 ? kSet : std::uint8_t{0});
    }
  }
  return mask;
}

}  // namespace

void collect(const StripRun& run, const StripTask& task, EdgeField& field) {
  for (std::size_t part = 0; part < field.parts.size(); ++part) {
    field.parts[part].region = statistics_of(run.rows(part), task.search.y);
    if (task.options.with_mask) field.parts[part].mask = mask_of(run, task, part);
  }
  sort_edges(run.edges(), task, field);
}

}  // namespace cylpose::opencl
