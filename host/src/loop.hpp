// Closed chains: separate things of the part's colour.
#pragma once

#include <cylpose/contour.hpp>
#include <cylpose/edge_field.hpp>
#include <optional>
#include <span>

namespace cylpose {

/// What a chain that closes on itself around the part's colour encloses, as if it were filled: area and moments,
/// rounded to whole numbers as those of a mask; no box. None for an open chain and for the border of a hole.
[[nodiscard]] std::optional<RegionStatistics> region_in_loop(std::span<const EdgePoint> points, const Chain& chain);

}  // namespace cylpose
