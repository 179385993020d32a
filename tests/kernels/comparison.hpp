// What all tests of the kernels compare: the opencl backend with the serial one, to the last bit.
#pragma once

#include <gtest/gtest.h>

#include <cylpose/backend.hpp>
#include <cylpose/opencl_devices.hpp>
#include <memory>
#include <ostream>
#include <string>
#include <vector>

namespace cylpose {

inline std::ostream& operator<<(std::ostream& out, const EdgePixel& edge) {
  return out << '(' << edge.x << ',' << edge.y << ") g " << edge.gx << ',' << edge.gy << " offset " << edge.offset_256
             << " strength " << static_cast<int>(edge.strength);
}

namespace testing {

/// How much there was to compare, so that a test can tell that it compared something.
struct Compared {
  std::int64_t mask_pixels = 0;
  std::size_t edges = 0;
};

inline const std::vector<PartModel>& four_parts() {
  static const std::vector<PartModel> models{{"red", 0.05, 0.4, 300, 60, 0.2, 0.1},
                                             {"most", 0.05, 0.4, 10, 290, 0.1, 0},
                                             {"green", 0.05, 0.4, 80, 170, 0.3, 0.2},
                                             {"bright", 0.05, 0.4, 0, 360, 0, 0.4}};
  return models;
}

/// Detects with both backends, masks included, and expects equality.
inline Compared expect_equal(Backend& opencl, const ImageView& image, const Roi& search,
                             const std::vector<PartModel>& parts, DetectOptions options = {}) {
  static const std::unique_ptr<Backend> serial = make_backend("serial");
  options.with_mask = true;
  const EdgeField expected = serial->detect(image, search, parts, options);
  const EdgeField actual = opencl.detect(image, search, parts, options);
  Compared compared;
  EXPECT_EQ(actual.searched, expected.searched);
  EXPECT_EQ(actual.parts.size(), expected.parts.size());
  for (std::size_t i = 0; i < std::min(actual.parts.size(), expected.parts.size()); ++i) {
    SCOPED_TRACE("part " + parts[i].name);
    EXPECT_EQ(actual.parts[i].region, expected.parts[i].region);
    EXPECT_EQ(actual.parts[i].mask.roi, expected.parts[i].mask.roi);
    EXPECT_TRUE(actual.parts[i].mask.pixels == expected.parts[i].mask.pixels);
    EXPECT_EQ(actual.parts[i].edges, expected.parts[i].edges);
    compared.mask_pixels += expected.parts[i].region.m00;
    compared.edges += expected.parts[i].edges.size();
  }
  return compared;
}

}  // namespace testing
}  // namespace cylpose
