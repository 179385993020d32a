#include <gtest/gtest.h>

#include <chrono>
#include <cylpose/graph/statistics.hpp>
#include <memory>
#include <thread>
#include <vector>

namespace cylpose::graph {
namespace {

using std::chrono::hours;
using std::chrono::microseconds;
using std::chrono::nanoseconds;

TEST(DurationHistogram, KnowsNothingOfNothing) {
  const DurationHistogram histogram;
  EXPECT_EQ(histogram.statistics().count, 0U);
  EXPECT_EQ(histogram.statistics().p99_ms, 0);
}

TEST(DurationHistogram, PercentilesAreRightToFivePercent) {
  for (const int scale_us : {1, 17, 1000, 50000}) {
    DurationHistogram histogram;
    for (int i = 1; i <= 1000; ++i) histogram.add(microseconds(std::int64_t{i} * scale_us));
    const DurationStatistics statistics = histogram.statistics();
    EXPECT_EQ(statistics.count, 1000U);
    const double ms = scale_us / 1000.0;
    EXPECT_DOUBLE_EQ(statistics.mean_ms, 500.5 * ms);
    EXPECT_NEAR(statistics.median_ms, 500 * ms, 25 * ms);
    EXPECT_NEAR(statistics.p95_ms, 950 * ms, 48 * ms);
    EXPECT_NEAR(statistics.p99_ms, 990 * ms, 50 * ms);
    EXPECT_DOUBLE_EQ(statistics.max_ms, 1000 * ms);
  }
}

TEST(DurationHistogram, TakesAnyDuration) {
  DurationHistogram histogram;
  for (const nanoseconds duration : {nanoseconds(-5), nanoseconds(0), nanoseconds(1), nanoseconds(hours(1000))}) {
    histogram.add(duration);
  }
  EXPECT_EQ(histogram.statistics().count, 4U);
  EXPECT_DOUBLE_EQ(histogram.statistics().max_ms, 3.6e9);
  EXPECT_LT(histogram.statistics().median_ms, 0.001);
}

TEST(DurationHistogram, CountsFromSeveralThreads) {
  DurationHistogram histogram;
  std::vector<std::thread> threads;
  for (int t = 0; t < 4; ++t) {
    threads.emplace_back([&] {
      for (int i = 0; i < 1000; ++i) histogram.add(microseconds(i));
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(histogram.statistics().count, 4000U);
  EXPECT_DOUBLE_EQ(histogram.statistics().mean_ms, 0.4995);
}

}  // namespace
}  // namespace cylpose::graph
