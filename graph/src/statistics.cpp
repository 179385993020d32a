#include <algorithm>
#include <bit>
#include <cylpose/graph/statistics.hpp>

namespace cylpose::graph {
namespace {

constexpr std::int64_t kNanosecondsPerUnit = 1000;  // the first class ends at 1 us, the second at 2
constexpr double kMilliseconds = 1e-6;              // of a nanosecond

template <typename T>
void raise_to(std::atomic<T>& value, T least) {
  T known = value.load(std::memory_order_relaxed);
  while (known < least && !value.compare_exchange_weak(known, least, std::memory_order_relaxed)) {
  }
}

}  // namespace

// Class of a value v below kPerDoubling: v; above: the leading bit's place and the kPerDoubling steps behind it.
void DurationHistogram::add(std::chrono::nanoseconds duration) {
  const std::int64_t ns = std::max<std::int64_t>(duration.count(), 0);
  const auto units = static_cast<std::uint64_t>(ns / kNanosecondsPerUnit);
  std::size_t index = static_cast<std::size_t>(units);
  if (units >= kPerDoubling) {
    const auto shift =
        static_cast<std::size_t>(std::bit_width(units)) - static_cast<std::size_t>(std::bit_width(kPerDoubling));
    index = std::min((shift + 1) * kPerDoubling + (static_cast<std::size_t>(units >> shift) - kPerDoubling),
                     classes_.size() - 1);
  }
  classes_[index].fetch_add(1, std::memory_order_relaxed);
  sum_ns_.fetch_add(ns, std::memory_order_relaxed);
  count_.fetch_add(1, std::memory_order_relaxed);
  raise_to(max_ns_, ns);
}

DurationStatistics DurationHistogram::statistics() const {
  DurationStatistics result;
  std::array<std::uint64_t, kPerDoubling * kDoublings> counts{};
  for (std::size_t i = 0; i < counts.size(); ++i) {
    counts[i] = classes_[i].load(std::memory_order_relaxed);
    result.count += counts[i];
  }
  if (result.count == 0) return result;
  const auto all = static_cast<double>(result.count);
  result.max_ms = static_cast<double>(max_ns_.load(std::memory_order_relaxed)) * kMilliseconds;
  result.mean_ms = static_cast<double>(sum_ns_.load(std::memory_order_relaxed)) * kMilliseconds / all;
  const auto percentile = [&](double share) {
    const auto wanted = static_cast<std::uint64_t>(share * all);
    std::uint64_t below = 0;
    for (std::size_t i = 0; i < counts.size(); ++i) {
      below += counts[i];
      if (below <= wanted) continue;
      // The middle of the class.
      const std::size_t shift = i < kPerDoubling ? 0 : i / kPerDoubling - 1;
      const std::size_t first = i < kPerDoubling ? i : (i % kPerDoubling + kPerDoubling) << shift;
      const double middle = static_cast<double>(first) + static_cast<double>(std::size_t{1} << shift) / 2;
      return std::min(middle * kNanosecondsPerUnit * kMilliseconds, result.max_ms);
    }
    return result.max_ms;
  };
  result.median_ms = percentile(0.5);
  result.p95_ms = percentile(0.95);
  result.p99_ms = percentile(0.99);
  return result;
}

}  // namespace cylpose::graph
