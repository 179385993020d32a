// Edge pixels of the response image along the border of a mask.
#pragma once

#include <cylpose/backend.hpp>
#include <cylpose/edge_field.hpp>
#include <cylpose/gate.hpp>
#include <cylpose/image.hpp>
#include <vector>

namespace cylpose::serial {

/// Pixels of `band` whose gradient is a maximum along its own direction and reaches options.edge_low; row-major order,
/// offsets zero. `search` is where pixels exist, and holds the band.
///
/// - Gradient: Sobel 3x3 of the response (gate.hpp), the response replicated beyond the edge of `search`. It is 8 times
///   the slope in levels per pixel.
/// - Direction: one of four, split at 22.5 degrees; tan(22.5 deg) = 13573 / 2^15, which splits all Sobel sums (at most
///   1020) as the exact value does.
/// - Maximum: the squared magnitude is larger than that of the inner neighbour (where the gradient points) and no
///   smaller than that of the outer one, so of two equal pixels the one inside the part stays, on every side alike.
///   Neighbours outside `search` have no gradient.
[[nodiscard]] std::vector<EdgePixel> find_edges(const ImageView& image, const Roi& search, const ColorGate& gate,
                                                const Mask& band, const DetectOptions& options);

}  // namespace cylpose::serial
