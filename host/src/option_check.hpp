// Small helpers for the is_valid functions of options.
#pragma once

#include <fmt/format.h>

#include <string>
#include <string_view>
#include <utility>

namespace cylpose {

inline bool invalid(std::string* why, std::string reason) {
  if (why != nullptr) *why = std::move(reason);
  return false;
}

/// True when value > 0; NaN is not.
inline bool require_positive(double value, std::string_view name, std::string* why) {
  return value > 0 || invalid(why, fmt::format("{} is {}; must be above 0", name, value));
}

inline bool require_at_least(int value, int least, std::string_view name, std::string* why) {
  return value >= least || invalid(why, fmt::format("{} is {}; must be at least {}", name, value, least));
}

inline bool require_share(double value, std::string_view name, std::string* why) {
  return (value >= 0 && value <= 1) || invalid(why, fmt::format("{} is {}; must lie in 0..1", name, value));
}

}  // namespace cylpose
