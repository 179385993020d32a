// Degrees, as cases are told, in radians, as they are computed with.
#pragma once

#include <numbers>

namespace cylpose::bench {

[[nodiscard]] constexpr double radians(double degrees) {
  return degrees * std::numbers::pi / 180;
}

}  // namespace cylpose::bench
