#include "strips.hpp"

#include <utility>

namespace cylpose::cluster {

Roi with_halo(const Roi& search, const Rows& rows) {
  return intersection(
      {search.x, search.y + rows.first - kStripHalo, search.width, rows.end - rows.first + 2 * kStripHalo}, search);
}

ImageView cropped(const ImageView& image, const Roi& roi) {
  return {image.row(roi.y) + std::ptrdiff_t{roi.x} * bytes_per_pixel(image.format), roi.width, roi.height, image.stride,
          image.format};
}

std::vector<PartEdges> detect_strip(Backend& backend, const ImageView& image, const Roi& search, const Rows& rows,
                                    std::span<const PartModel> parts, DetectOptions options) {
  const Roi tall = with_halo(search, rows);
  const int halo_above = search.y + rows.first - tall.y;
  options.rows = {halo_above, halo_above + rows.end - rows.first};
  options.locate = false;
  return backend.detect(image, tall, parts, options).parts;
}

void shift(PartEdges& part, int x, int y) {
  RegionStatistics& m = part.region;
  const std::int64_t dx = x;
  const std::int64_t dy = y;
  m.m20 += 2 * dx * m.m10 + dx * dx * m.m00;
  m.m11 += dx * m.m01 + dy * m.m10 + dx * dy * m.m00;
  m.m02 += 2 * dy * m.m01 + dy * dy * m.m00;
  m.m10 += dx * m.m00;
  m.m01 += dy * m.m00;
  if (m.m00 > 0) {
    m.box.x += x;
    m.box.y += y;
  }
  for (EdgePixel& edge : part.edges) {
    edge.x = static_cast<std::int16_t>(edge.x + x);
    edge.y = static_cast<std::int16_t>(edge.y + y);
  }
}

void append(std::vector<PartEdges>& frame, std::vector<PartEdges>&& strip) {
  for (std::size_t i = 0; i < frame.size(); ++i) {
    RegionStatistics& sum = frame[i].region;
    const RegionStatistics& more = strip[i].region;
    sum.m00 += more.m00;
    sum.m10 += more.m10;
    sum.m01 += more.m01;
    sum.m20 += more.m20;
    sum.m11 += more.m11;
    sum.m02 += more.m02;
    sum.box = united(sum.box, more.box);
    std::vector<EdgePixel>& edges = frame[i].edges;
    edges.insert(edges.end(), strip[i].edges.begin(), strip[i].edges.end());
  }
}

}  // namespace cylpose::cluster
