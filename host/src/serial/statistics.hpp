// Area, raw moments and bounding box of a mask.
#pragma once

#include <cylpose/backend.hpp>
#include <cylpose/edge_field.hpp>

namespace cylpose::serial {

/// In frame coordinates, exact.
[[nodiscard]] RegionStatistics statistics_of(const Mask& mask);

/// Leaves of a part what lies in `rows` of the mask: its edges there, and the statistics of the mask there.
void keep_rows(const Rows& rows, const Mask& mask, PartEdges& part);

}  // namespace cylpose::serial
