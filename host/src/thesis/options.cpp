#include <fmt/format.h>

#include <cmath>
#include <cylpose/thesis.hpp>
#include <numbers>
#include <utility>

namespace cylpose {

bool ThesisOptions::is_valid(std::string* why) const {
  struct Range {
    const char* name;
    double value;
    double least;
    double most;
  };
  constexpr double kQuarterTurn = std::numbers::pi / 2;
  constexpr double kTiny = 1e-9;  // stands for "above zero"
  constexpr double kHuge = 1e9;
  const Range ranges[] = {
      {"search_growth", search_growth, 0, kHuge},
      {"min_edge_size", static_cast<double>(min_edge_size), 2, kHuge},
      {"max_chord_distance_px", max_chord_distance_px, kTiny, kHuge},
      {"max_squared_error_px2", max_squared_error_px2, kTiny, kHuge},
      {"upright_error_factor", upright_error_factor, 1, kHuge},
      {"upright_tolerance_rad", upright_tolerance_rad, 0, kQuarterTurn / 2},
      {"equal_angle_rad", equal_angle_rad, kTiny, kQuarterTurn},
      {"equal_distance_px", equal_distance_px, kTiny, kHuge},
      {"max_angle_to_region_rad", max_angle_to_region_rad, 0, kQuarterTurn},
      {"clear_support_ratio", clear_support_ratio, 1, kHuge},
  };
  for (const Range& range : ranges) {
    if (range.value >= range.least && range.value <= range.most) continue;  // false for NaN
    if (why != nullptr) {
      *why = fmt::format("{} is {}; give a number within {}..{}", range.name, range.value, range.least, range.most);
    }
    return false;
  }
  return true;
}

}  // namespace cylpose
