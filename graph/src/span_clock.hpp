// Measures the spans of a node where somebody wants them.
#pragma once

#include <cylpose/graph/frame_task.hpp>
#include <string_view>

namespace cylpose::graph {

class SpanClock {
 public:
  explicit SpanClock(const NodeObserver& observer)
      : observer_(observer), last_(observer ? Clock::now() : Clock::time_point()) {}

  /// Ends a span that began with construction or the last lap.
  void lap(std::string_view node, const FrameTask& frame) {
    if (!observer_) return;
    const Clock::time_point now = Clock::now();
    observer_({node, frame, last_, now});
    last_ = now;
  }

 private:
  const NodeObserver& observer_;
  Clock::time_point last_;
};

}  // namespace cylpose::graph
