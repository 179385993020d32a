// Names of the counters that hold the time of a stage. Counters are sorted by name, so the name has the stage's place.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace cylpose::bench {

inline constexpr std::string_view kStageCounter = "stage_ms/";

/// `place` counts from 0, up to 99: "stage_ms/00/gate".
[[nodiscard]] inline std::string stage_counter(std::size_t place, std::string_view stage) {
  const std::string digits = std::to_string(place);
  return std::string(kStageCounter) + std::string(digits.size() < 2 ? 1 : 0, '0') + digits + "/" + std::string(stage);
}

/// The stage's name out of the counter's. Requires a counter that starts with kStageCounter.
[[nodiscard]] inline std::string stage_of_counter(std::string_view counter) {
  return std::string(counter.substr(counter.find('/', kStageCounter.size()) + 1));
}

}  // namespace cylpose::bench
