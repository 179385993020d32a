// Area, raw moments and bounding box of a mask.
#pragma once

#include <cylpose/edge_field.hpp>

namespace cylpose::serial {

/// In frame coordinates, exact.
[[nodiscard]] RegionStatistics statistics_of(const Mask& mask);

}  // namespace cylpose::serial
