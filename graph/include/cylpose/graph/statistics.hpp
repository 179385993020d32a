// How often, and how long: figures of a running pipeline in constant memory.
#pragma once

#include <array>
#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace cylpose::graph {

/// What is known of some durations. Percentiles are exact to 5 %, the rest to the last bit.
struct DurationStatistics {
  std::uint64_t count = 0;
  double mean_ms = 0;
  double median_ms = 0;
  double p95_ms = 0;
  double p99_ms = 0;
  double max_ms = 0;
};

/// Counts durations from 1 us to an hour in classes, sixteen per doubling. Any thread, no lock.
class DurationHistogram {
 public:
  void add(std::chrono::nanoseconds duration);
  [[nodiscard]] DurationStatistics statistics() const;

 private:
  static constexpr std::size_t kPerDoubling = 16;
  static constexpr std::size_t kDoublings = 32;

  std::array<std::atomic<std::uint64_t>, kPerDoubling * kDoublings> classes_{};
  std::atomic<std::uint64_t> count_ = 0;
  std::atomic<std::int64_t> sum_ns_ = 0;
  std::atomic<std::int64_t> max_ns_ = 0;
};

/// How long a node worked on frames; one entry per visit, so that frames searched again count twice.
struct NodeStatistics {
  std::string node;
  DurationStatistics busy;
};

struct PipelineStatistics {
  std::uint64_t accepted = 0;   ///< frames that put or try_put took
  std::uint64_t dropped = 0;    ///< of these, replaced by a newer one (Policy::kLatest), or not delivered at cancel
  std::uint64_t delivered = 0;  ///< of these, given to the sink; what is missing is under way
  std::uint64_t failed = 0;     ///< of those delivered, frames with a failure
  std::uint64_t searched_again = 0;  ///< of those delivered, frames searched as a whole after a region
  DurationStatistics latency;        ///< from put to the call of the sink
  std::vector<NodeStatistics> nodes;
};

}  // namespace cylpose::graph
