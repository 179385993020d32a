// 3x3 erosion and dilation of masks. Pixels outside the mask's rectangle do not exist: they neither erode nor dilate.
#pragma once

#include <cylpose/edge_field.hpp>

namespace cylpose::serial {

[[nodiscard]] Mask eroded(const Mask& mask);
[[nodiscard]] Mask dilated(const Mask& mask);

/// The pixels within Chebyshev distance 2 of the mask's border: dilated twice, without what is left after eroding
/// twice. Only mask pixels in `box` are set; the result covers `box` grown by 2 and cut to the mask's rectangle.
[[nodiscard]] Mask border_band(const Mask& mask, const Roi& box);

}  // namespace cylpose::serial
