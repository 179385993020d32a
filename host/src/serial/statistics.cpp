#include "serial/statistics.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <vector>

namespace cylpose::serial {
namespace {

// 0^2 + 1^2 + ... + n^2; also right for n = -1.
std::int64_t sum_of_squares_to(std::int64_t n) {
  return n * (n + 1) * (2 * n + 1) / 6;
}

// The pixels [first, end) of row y.
void add_run(RegionStatistics& region, std::int64_t first, std::int64_t end, std::int64_t y) {
  const std::int64_t count = end - first;
  const std::int64_t sum_x = count * (first + end - 1) / 2;
  region.m00 += count;
  region.m10 += sum_x;
  region.m01 += count * y;
  region.m20 += sum_of_squares_to(end - 1) - sum_of_squares_to(first - 1);
  region.m11 += sum_x * y;
  region.m02 += count * y * y;
}

}  // namespace

RegionStatistics statistics_of(const Mask& mask) {
  RegionStatistics region;
  int left = mask.roi.width;
  int right = 0;
  int top = mask.roi.height;
  int bottom = 0;
  for (int y = 0; y < mask.roi.height; ++y) {
    const std::uint8_t* row = mask.pixels.data() + static_cast<std::ptrdiff_t>(y) * mask.roi.width;
    // From position x to the next pixel of that value; memchr is what makes empty rows cheap.
    const auto next = [&](int x, std::uint8_t value) {
      const void* found = std::memchr(row + x, value, static_cast<std::size_t>(mask.roi.width - x));
      return found == nullptr ? mask.roi.width : static_cast<int>(static_cast<const std::uint8_t*>(found) - row);
    };
    for (int first = next(0, 255); first < mask.roi.width;) {
      const int end = next(first, 0);
      add_run(region, mask.roi.x + first, mask.roi.x + end, mask.roi.y + y);
      left = std::min(left, first);
      right = std::max(right, end);
      top = std::min(top, y);
      bottom = y + 1;
      first = next(end, 255);
    }
  }
  if (region.m00 > 0) region.box = {mask.roi.x + left, mask.roi.y + top, right - left, bottom - top};
  return region;
}

void keep_rows(const Rows& rows, const Mask& mask, PartEdges& part) {
  if (rows.first <= 0 && rows.end >= mask.roi.height) return;
  Mask kept;
  kept.roi = intersection(mask.roi, {mask.roi.x, mask.roi.y + rows.first, mask.roi.width,
                                     std::min(rows.end, mask.roi.height) - rows.first});
  const auto width = static_cast<std::size_t>(mask.roi.width);
  const auto first = mask.pixels.begin() + static_cast<std::ptrdiff_t>(width) * (kept.roi.y - mask.roi.y);
  kept.pixels.assign(first, first + static_cast<std::ptrdiff_t>(width) * kept.roi.height);
  part.region = statistics_of(kept);
  std::erase_if(part.edges, [&](const EdgePixel& edge) { return edge.y < kept.roi.y || edge.y >= kept.roi.bottom(); });
}

}  // namespace cylpose::serial
