// What overlay and debug pictures draw alike.
#pragma once

#include <cylpose/image.hpp>

#include "canvas.hpp"

namespace cylpose {

/// A dashed rectangle along the region's outermost pixels; nothing for an empty one.
inline void draw_search_region(Canvas* canvas, const Roi& region) {
  if (region.empty()) return;
  const double left = region.x;
  const double top = region.y;
  const double right = region.right() - 1;
  const double bottom = region.bottom() - 1;
  canvas->line({{left, top}, {right, top}, {right, bottom}, {left, bottom}, {left, top}}, {200, 200, 200}, 1,
               LineStyle::kDashed);
}

}  // namespace cylpose
