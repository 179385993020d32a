// Wall time per stage, summed over the parts.
#pragma once

#include <chrono>
#include <cylpose/edge_field.hpp>
#include <string_view>
#include <vector>

namespace cylpose {

class StageClock {
 public:
  /// Ends a stage: adds the time since construction or the last call to its entry.
  void lap(std::string_view stage) {
    const auto now = std::chrono::steady_clock::now();
    add(stage, std::chrono::duration<double, std::milli>(now - last_).count());
    last_ = now;
  }

  /// Leaves out what happened since the last lap.
  void skip() { last_ = std::chrono::steady_clock::now(); }

  [[nodiscard]] const std::vector<StageTime>& times() const { return times_; }

 private:
  void add(std::string_view stage, double milliseconds) {
    for (StageTime& time : times_) {
      if (time.stage == stage) {
        time.milliseconds += milliseconds;
        return;
      }
    }
    times_.push_back({stage, milliseconds});
  }

  std::chrono::steady_clock::time_point last_ = std::chrono::steady_clock::now();
  std::vector<StageTime> times_;
};

}  // namespace cylpose
