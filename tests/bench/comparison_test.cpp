#include "comparison.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "bench_files.hpp"

namespace cylpose::bench {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

TEST(Comparison, OnlyABestNewRunBehindTheWorstOldOneIsSlower) {
  const std::vector<BenchRun> old_runs{testing::loaded({{"apart", {10}}, {"touching", {10}}, {"gone", {1}}}),
                                       testing::loaded({{"apart", {14}}, {"touching", {14}}})};
  const std::vector<BenchRun> new_runs{testing::loaded({{"apart", {15}}, {"touching", {14}}, {"added", {1}}}),
                                       testing::loaded({{"apart", {30}}, {"touching", {30}}})};
  const std::vector<Change> both = changes(old_runs, new_runs);
  ASSERT_EQ(both.size(), 2U);
  EXPECT_EQ(both[0].name, "apart");
  EXPECT_TRUE(both[0].is_slower());
  EXPECT_DOUBLE_EQ(both[0].old_median, 0.012);
  EXPECT_DOUBLE_EQ(both[0].new_median, 0.0225);
  EXPECT_EQ(both[1].name, "touching");
  EXPECT_FALSE(both[1].is_slower());
  EXPECT_THAT(text_of({both[0]}), HasSubstr("SLOWER"));
  EXPECT_THAT(text_of({both[1]}), Not(HasSubstr("SLOWER")));
}

TEST(Comparison, FasterIsNeverSlower) {
  const std::vector<BenchRun> old_runs{testing::loaded({{"a", {10, 12}}})};
  const std::vector<BenchRun> new_runs{testing::loaded({{"a", {2, 3}}})};
  EXPECT_FALSE(changes(old_runs, new_runs).at(0).is_slower());
  EXPECT_TRUE(changes(new_runs, old_runs).at(0).is_slower());
}

}  // namespace
}  // namespace cylpose::bench
