#include "results.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cylpose/error.hpp>

#include "bench_files.hpp"
#include "stage_counter.hpp"

namespace cylpose::bench {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

TEST(Results, RepetitionsOfABenchmarkComeTogetherInMilliseconds) {
  nlohmann::json json = testing::run_json({{"a", {1000, 3000}, {{"GB/s", 4}}}, {"b", {5}}});
  nlohmann::json aggregate = json["benchmarks"][0];
  aggregate["run_type"] = "aggregate";
  aggregate["real_time"] = 77;
  json["benchmarks"].push_back(aggregate);
  // Interleaved runs come in any order.
  std::ranges::reverse(json["benchmarks"]);
  const BenchRun run = testing::loaded_json(json);
  ASSERT_EQ(run.benchmarks.size(), 2U);
  EXPECT_EQ(run.benchmarks[0].name, "a");
  EXPECT_THAT(run.benchmarks[0].milliseconds, ElementsAre(3, 1));
  EXPECT_EQ(median_counter(run.benchmarks[0], "GB/s"), 4);
  EXPECT_EQ(median_counter(run.benchmarks[1], "GB/s"), std::nullopt);
  EXPECT_EQ(run.find("b"), &run.benchmarks[1]);
  EXPECT_EQ(run.find("c"), nullptr);
  EXPECT_EQ(run.context.at("processor"), "abacus");
  EXPECT_EQ(run.context.at("load_avg"), "[0.5,0.25]");
}

TEST(Results, FailedEmptyAndForeignFilesAreRefusedByName) {
  nlohmann::json failed = testing::run_json({{"a", {1000}}});
  failed["benchmarks"][0]["error_occurred"] = true;
  failed["benchmarks"][0]["error_message"] = "no device";
  EXPECT_THAT([&] { testing::loaded_json(failed); }, ThrowsMessage<Error>(HasSubstr("a failed: no device")));
  EXPECT_THAT([] { testing::loaded({}); }, ThrowsMessage<Error>(HasSubstr("no benchmark")));
  EXPECT_THAT([] { testing::loaded_json(nlohmann::json::array()); }, ThrowsMessage<Error>(HasSubstr("no output")));
  nlohmann::json unit = testing::run_json({{"a", {1000}}});
  unit["benchmarks"][0]["time_unit"] = "fortnight";
  EXPECT_THAT([&] { testing::loaded_json(unit); }, ThrowsMessage<Error>(HasSubstr("fortnight")));
  EXPECT_THAT([] { static_cast<void>(load_run("/nonexistent/run.json")); },
              ThrowsMessage<Error>(HasSubstr("/nonexistent/run.json")));
}

TEST(Results, MedianOfOddAndEvenNumbers) {
  EXPECT_EQ(median({3}), 3);
  EXPECT_EQ(median({9, 1, 2}), 2);
  EXPECT_EQ(median({9, 1, 2, 4}), 3);
}

TEST(Results, StagesKeepTheirOrder) {
  Measured benchmark{"a", {1}, {}};
  const std::vector<std::string> names{"upload", "gate", "edges", "c", "d", "e", "f", "g", "h", "i", "a last one"};
  for (std::size_t i = 0; i < names.size(); ++i) benchmark.counters[stage_counter(i, names[i])] = {2, 1, 3};
  benchmark.counters["real_time"] = {1};
  std::vector<std::string> found;
  for (const Stage& stage : stages_of(benchmark)) {
    found.push_back(stage.name);
    EXPECT_EQ(stage.milliseconds, 2);
  }
  EXPECT_EQ(found, names);
}

TEST(Results, CasesHaveFourNames) {
  const auto name = parsed_case("detect/opencl/full/1280x720");
  ASSERT_TRUE(name);
  EXPECT_EQ(name->kind, "detect");
  EXPECT_EQ(name->backend, "opencl");
  EXPECT_EQ(name->scene, "full");
  EXPECT_EQ(name->size, "1280x720");
  for (const char* other : {"", "overhead/opencl", "start/opencl/cold", "a/b/c/d/e"}) {
    EXPECT_FALSE(parsed_case(other)) << other;
  }
}

}  // namespace
}  // namespace cylpose::bench
