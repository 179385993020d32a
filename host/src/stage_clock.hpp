// Wall times of consecutive stages.
#pragma once

#include <chrono>
#include <cylpose/edge_field.hpp>
#include <string_view>
#include <vector>

namespace cylpose {

class StageClock {
 public:
  /// The time since construction or the last lap, under the name of the stage that ends here (a string literal).
  void lap(std::string_view stage) {
    const auto now = Clock::now();
    times_.push_back({stage, std::chrono::duration<double, std::milli>(now - start_).count()});
    start_ = now;
  }
  [[nodiscard]] const std::vector<StageTime>& times() const { return times_; }

 private:
  using Clock = std::chrono::steady_clock;
  Clock::time_point start_ = Clock::now();
  std::vector<StageTime> times_;
};

}  // namespace cylpose
