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
  int y = first_y;
  for (const RowStatistics& row : rows) {
    if (row.count > 0) {
      if (region.m00 == 0) top = y;
      bottom = y + 1;
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

void add(RegionStatistics& sum, const RegionStatistics& other) {
  sum.m00 += other.m00;
  sum.m10 += other.m10;
  sum.m01 += other.m01;
  sum.m20 += other.m20;
  sum.m11 += other.m11;
  sum.m02 += other.m02;
  sum.box = united(sum.box, other.box);
}

EdgePixel edge_pixel(const KernelEdge& edge, bool located) {
  const std::int16_t offset = located ? edge.offset_256 : std::int16_t{0};
  const auto strength = static_cast<EdgeStrength>(edge.kind & 3);
  return {edge.x, edge.y, edge.gx, edge.gy, offset, strength, static_cast<EdgeCue>(edge.kind >> 2 & 7)};
}

// The kernel finds the edges of a row from left to right, but the rows in any order: a counting sort by part and row.
void append_sorted(std::span<const KernelEdge> edges, const StripTask& task, EdgeField& field) {
  const auto rows = static_cast<std::size_t>(task.end_row - task.first_row);
  const int first_y = task.search.y + task.first_row;
  std::vector<std::size_t> places(field.parts.size() * rows + 1);
  const auto row_of = [&](const KernelEdge& edge) {
    return static_cast<std::size_t>(edge.kind >> 5) * rows + static_cast<std::size_t>(edge.y - first_y);
  };
  for (const KernelEdge& edge : edges) ++places[row_of(edge) + 1];
  std::partial_sum(places.begin(), places.end(), places.begin());
  std::vector<EdgePixel> sorted(edges.size());
  std::vector<std::size_t> next(places);
  for (const KernelEdge& edge : edges) sorted[next[row_of(edge)]++] = edge_pixel(edge, task.options.locate);
  for (std::size_t part = 0; part < field.parts.size(); ++part) {
    const auto at = [&](std::size_t i) { return sorted.begin() + static_cast<std::ptrdiff_t>(places[i * rows]); };
    std::vector<EdgePixel>& all = field.parts[part].edges;
    all.insert(all.end(), at(part), at(part + 1));
  }
}

void append_mask(const StripJob& job, const StripTask& task, std::size_t part, Mask& mask) {
  constexpr std::uint8_t kSet = 255;
  mask.roi = task.search;
  for (int y = task.first_row; y < task.end_row; ++y) {
    const std::span<const CylU64> words = job.mask_row(part, y);
    for (std::size_t x = 0; x < static_cast<std::size_t>(task.search.width); ++x) {
      mask.pixels.push_back((words[x / 64] >> (x % 64) & 1) != 0 ? kSet : std::uint8_t{0});
    }
  }
}

}  // namespace

void collect(const std::vector<DoneStrip>& strips, EdgeField& field) {
  for (const DoneStrip& strip : strips) {
    const StripJob& job = strip.lease.job();
    for (std::size_t i = 0; i < field.parts.size(); ++i) {
      PartEdges& part = field.parts[i];
      add(part.region, statistics_of(job.rows(i), strip.task.search.y + strip.task.first_row));
      if (strip.task.options.with_mask) append_mask(job, strip.task, i, part.mask);
    }
    append_sorted(job.edges(), strip.task, field);
    const std::vector<StageTime> times = job.times();
    field.times.insert(field.times.end(), times.begin(), times.end());
  }
}

}  // namespace cylpose::opencl
