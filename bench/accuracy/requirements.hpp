// What the accuracy has to be, each requirement with what was measured.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "location.hpp"
#include "pose_outcome.hpp"

namespace cylpose::bench {

struct Requirement {
  std::string name;
  double measured;
  double low;   ///< smallest value that will do
  double high;  ///< largest
  std::string unit;

  /// Not with NaN.
  [[nodiscard]] bool is_met() const { return measured >= low && measured <= high; }
};

/// Those that can be judged from what was measured: of groups that did not run there are none.
[[nodiscard]] std::vector<Requirement> location_requirements(std::span<const Location> locations);
[[nodiscard]] std::vector<Requirement> pose_requirements(std::span<const Outcome> outcomes);

[[nodiscard]] std::string text_of(std::span<const Requirement> requirements);

}  // namespace cylpose::bench
