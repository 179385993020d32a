// Whether an end that is seen inside an outline is the rim of a base: then the outline's own end is not the part's.
#pragma once

#include <Eigen/Core>
#include <span>

#include "cylpose/contour.hpp"

namespace cylpose {

/// By how much, in pixels, edge points bulge along `outward` over their length across it: the height of the parabola
/// through them. 0 where a straight line fits them nearly as well (an occluder's edge), where they are hollow or too
/// few. `outward` is a unit vector in the ideal camera's image, pointing out of the part.
[[nodiscard]] double rounded_end_px(std::span<const EdgePoint> points, const Eigen::Vector2d& outward);

}  // namespace cylpose
