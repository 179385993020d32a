#include <gmock/gmock.h>
#include <oneapi/tbb/global_control.h>

#include <algorithm>
#include <cylpose/estimator.hpp>
#include <cylpose/graph/pipeline.hpp>
#include <future>
#include <random>
#include <set>
#include <thread>

#include "stream.hpp"

namespace cylpose::graph {
namespace {

using testing::expect_same;
using ::testing::HasSubstr;
using testing::kStreamFrames;
using testing::make_slow_device;
using testing::one_at_a_time;
using testing::stream_camera;
using testing::stream_frame;
using testing::stream_parts;

std::vector<InputFrame> whole_stream() {
  std::vector<InputFrame> frames;
  for (int i = 0; i < kStreamFrames; ++i) frames.push_back(stream_frame(i));
  return frames;
}

// What the sink got; only for one pipeline's thread and, after wait_for_all, the test's.
using Results = std::vector<FramePtr>;

Sink to(Results& results) {
  return [&results](const FramePtr& frame) { results.push_back(frame); };
}

Results run(PipelineOptions options, std::unique_ptr<Backend> backend, const std::vector<InputFrame>& frames) {
  Results results;
  Pipeline pipeline(stream_camera(), stream_parts(), std::move(backend), to(results), std::move(options));
  for (const InputFrame& frame : frames) EXPECT_TRUE(pipeline.put(frame));
  pipeline.wait_for_all();
  return results;
}

void expect_stream(const Results& results, const std::vector<FrameEstimate>& expected) {
  ASSERT_EQ(results.size(), expected.size());
  for (std::size_t i = 0; i < results.size(); ++i) {
    EXPECT_EQ(results[i]->id, static_cast<std::int64_t>(i));
    expect_same(results[i]->estimate, expected[i], "frame " + std::to_string(i));
  }
}

std::size_t found(const std::vector<FrameEstimate>& estimates) {
  return static_cast<std::size_t>(std::ranges::count_if(
      estimates, [](const FrameEstimate& frame) { return frame.parts[0].status == PoseStatus::kOk; }));
}

class Pipelines : public ::testing::TestWithParam<int> {
  // As many threads as are asked for, however few cores there are.
  tbb::global_control control_{tbb::global_control::max_allowed_parallelism, 9};
};
INSTANTIATE_TEST_SUITE_P(OneToEight, Pipelines, ::testing::Range(1, 9));

TEST_P(Pipelines, GiveTheResultsOfOneFrameAtATimeWhateverTheTiming) {
  const std::vector<InputFrame> frames = whole_stream();
  PipelineOptions options;
  options.lag = GetParam();
  const std::vector<FrameEstimate> expected = one_at_a_time(frames, static_cast<std::size_t>(options.lag));
  ASSERT_GE(found(expected), frames.size() - 4) << "there must be something to compare";
  for (const int threads : {1, 2, 5, 8}) {
    options.threads = threads;
    SCOPED_TRACE(threads);
    const auto seed = static_cast<unsigned>(options.lag * 100 + threads);
    expect_stream(run(options, make_slow_device(seed, 3000), frames), expected);
  }
  expect_stream(run(options, make_backend("serial"), frames), expected);
}

TEST_P(Pipelines, WithTheFilterToo) {
  const std::vector<InputFrame> frames = whole_stream();
  PipelineOptions options;
  options.lag = GetParam();
  options.filter.emplace();
  const std::vector<FrameEstimate> expected =
      one_at_a_time(frames, static_cast<std::size_t>(options.lag), options.filter);
  EXPECT_GT(std::ranges::count_if(expected,
                                  [](const auto& frame) { return frame.parts[0].status == PoseStatus::kPredicted; }),
            0);
  expect_stream(run(options, make_slow_device(7, 2000), frames), expected);
}

TEST_P(Pipelines, AreAsLongAsTheirSinkIsSlow) {
  const std::vector<InputFrame> frames = whole_stream();
  PipelineOptions options;
  options.lag = GetParam();
  Results results;
  std::mt19937 random(1);
  Pipeline pipeline(
      stream_camera(), stream_parts(), make_backend("serial"),
      [&](const FramePtr& frame) {
        std::this_thread::sleep_for(std::chrono::microseconds(random() % 3000));
        results.push_back(frame);
      },
      options);
  for (const InputFrame& frame : frames) ASSERT_TRUE(pipeline.put(frame));
  pipeline.wait_for_all();
  expect_stream(results, one_at_a_time(frames, static_cast<std::size_t>(options.lag)));
}

TEST_P(Pipelines, DropOnlyStaleFramesOfALiveStreamAndSolveTheOthersAlike) {
  PipelineOptions options;
  options.policy = Policy::kLatest;
  options.lag = GetParam();
  Results results;
  std::promise<void> go;
  const std::shared_future<void> gone = go.get_future().share();
  Pipeline pipeline(
      stream_camera(), stream_parts(), make_slow_device(3, 2000),
      [&](const FramePtr& frame) {
        gone.wait();
        results.push_back(frame);
      },
      options);
  std::mt19937 random(static_cast<unsigned>(options.lag));
  constexpr int kFrames = 60;
  for (int i = 0; i < kFrames; ++i) {
    if (i == kFrames / 2) go.set_value();  // the sink was behind so far
    ASSERT_TRUE(pipeline.try_put(stream_frame(i)));
    std::this_thread::sleep_for(std::chrono::microseconds(random() % 1000));
  }
  pipeline.wait_for_all();
  const PipelineStatistics statistics = pipeline.statistics();
  EXPECT_EQ(statistics.accepted, static_cast<std::uint64_t>(kFrames));
  EXPECT_EQ(statistics.delivered, results.size());
  EXPECT_EQ(statistics.dropped, kFrames - results.size());
  EXPECT_GE(statistics.dropped, static_cast<std::uint64_t>(kFrames / 2 - options.lag - 1));
  EXPECT_EQ(results.back()->id, kFrames - 1) << "the newest is never dropped";
  std::vector<InputFrame> taken;
  for (const FramePtr& frame : results) {
    EXPECT_TRUE(taken.empty() || taken.back().id < frame->id);
    taken.push_back(stream_frame(static_cast<int>(frame->id)));
  }
  const std::vector<FrameEstimate> expected = one_at_a_time(taken, static_cast<std::size_t>(options.lag));
  for (std::size_t i = 0; i < results.size(); ++i) {
    expect_same(results[i]->estimate, expected[i], "frame " + std::to_string(results[i]->id));
  }
}

TEST(Pipeline, WithLagOneIsTheEstimator) {
  const auto estimator = make_estimator("default", stream_camera(), stream_parts(), "serial");
  PipelineOptions options;
  options.lag = 1;
  std::vector<InputFrame> frames;
  std::vector<FrameEstimate> expected;
  for (int i = 0; i < kStreamFrames; ++i) {
    frames.push_back(testing::good_frame(i));
    expected.push_back(estimator->estimate(frames.back().image.view));
  }
  expect_stream(run(options, make_backend("serial"), frames), expected);
}

TEST(Pipeline, TakesAWholeEstimatorToo) {
  const auto estimator = make_estimator("thesis", stream_camera(), stream_parts());
  std::vector<FrameEstimate> expected;
  Results results;
  Pipeline pipeline(stream_camera(), stream_parts(), make_estimator("thesis", stream_camera(), stream_parts()),
                    to(results));
  for (int i = 0; i < 12; ++i) {
    expected.push_back(estimator->estimate(testing::good_frame(i).image.view));
    ASSERT_TRUE(pipeline.put(testing::good_frame(i)));
  }
  pipeline.wait_for_all();
  EXPECT_GT(found(expected), 0U);
  expect_stream(results, expected);
}

TEST(Pipeline, BadFramesArriveAsFailuresAndTheStreamGoesOn) {
  const Results results = run({}, make_backend("serial"), whole_stream());
  ASSERT_EQ(results.size(), static_cast<std::size_t>(kStreamFrames));
  std::set<std::int64_t> failed;
  for (const FramePtr& frame : results) {
    if (!frame->failure) continue;
    failed.insert(frame->id);
    ASSERT_EQ(frame->estimate.parts.size(), 1U);
    EXPECT_EQ(frame->estimate.parts[0].status, PoseStatus::kNone);
    EXPECT_EQ(frame->estimate.parts[0].reason, frame->failure->what());
  }
  EXPECT_EQ(failed, (std::set<std::int64_t>{5, 17}));
  EXPECT_THAT(results[17]->failure->what(), HasSubstr("40 x 30"));
  EXPECT_EQ(results[17]->failure->kind(), ErrorKind::kInput);
}

class BrokenBackend final : public Backend {
 public:
  [[nodiscard]] std::string_view name() const override { return "broken"; }
  [[nodiscard]] EdgeField detect(const ImageView&, const Roi&, std::span<const PartModel>,
                                 const DetectOptions&) override {
    throw Error(ErrorKind::kDevice, "the device is gone");
  }
};

TEST(Pipeline, ADeviceThatFailsFailsItsFramesOnly) {
  std::vector<InputFrame> frames;
  for (int i = 0; i < 8; ++i) frames.push_back(testing::good_frame(i));
  for (const FramePtr& frame : run({}, std::make_unique<BrokenBackend>(), frames)) {
    ASSERT_TRUE(frame->failure);
    EXPECT_EQ(frame->failure->kind(), ErrorKind::kDevice);
    EXPECT_STREQ(frame->failure->what(), "the device is gone");
  }
}

TEST(Pipeline, TimeStampsThatDoNotIncreaseFailTheirFrameWhereThereIsAFilter) {
  std::vector<InputFrame> frames;
  for (int i = 0; i < 8; ++i) frames.push_back(testing::good_frame(i));
  frames[4].timestamp_s = frames[3].timestamp_s;
  PipelineOptions options;
  options.filter.emplace();
  const Results results = run(options, make_backend("serial"), frames);
  ASSERT_EQ(results.size(), 8U);
  for (const FramePtr& frame : results) EXPECT_EQ(frame->failure.has_value(), frame->id == 4);
}

TEST(Pipeline, HasRoomForAFewFramesAndTheNextOneWaits) {
  std::promise<void> go;
  const std::shared_future<void> gone = go.get_future().share();
  PipelineOptions options;
  options.lag = 2;
  std::size_t delivered = 0;
  Pipeline pipeline(
      stream_camera(), stream_parts(), make_backend("serial"),
      [&](const FramePtr&) {
        gone.wait();
        ++delivered;
      },
      options);
  std::uint64_t taken = 0;
  while (pipeline.try_put(testing::good_frame(static_cast<int>(taken)))) ++taken;
  EXPECT_EQ(taken, 4U);
  EXPECT_EQ(pipeline.statistics().accepted, taken) << "what was not taken does not count";
  std::thread waits([&] { EXPECT_TRUE(pipeline.put(testing::good_frame(4))); });
  go.set_value();
  waits.join();
  pipeline.wait_for_all();
  EXPECT_EQ(delivered, taken + 1);
}

TEST(Pipeline, WhatTheSinkThrowsComesOutOfTheWait) {
  int calls = 0;
  Pipeline pipeline(stream_camera(), stream_parts(), make_backend("serial"), [&](const FramePtr& frame) {
    ++calls;
    if (frame->id == 2) throw Error(ErrorKind::kOutput, "the disk is full");
  });
  int put = 0;
  while (pipeline.put(testing::good_frame(put))) ++put;
  try {
    pipeline.wait_for_all();
    FAIL() << "it must throw";
  } catch (const Error& error) {
    EXPECT_STREQ(error.what(), "the disk is full");
  }
  EXPECT_EQ(calls, 3);
  pipeline.wait_for_all();  // thrown once
  EXPECT_FALSE(pipeline.try_put(testing::good_frame(0)));
}

TEST(Pipeline, CanBeCancelledFromItsSink) {
  int calls = 0;
  Pipeline* self = nullptr;
  Pipeline pipeline(stream_camera(), stream_parts(), make_backend("serial"), [&](const FramePtr& frame) {
    ++calls;
    if (frame->id == 3) self->cancel();
  });
  self = &pipeline;
  int put = 0;
  while (pipeline.put(testing::good_frame(put))) ++put;
  pipeline.wait_for_all();
  EXPECT_EQ(calls, 4);
  const PipelineStatistics statistics = pipeline.statistics();
  EXPECT_EQ(statistics.delivered, 4U);
  EXPECT_EQ(statistics.accepted, statistics.delivered + statistics.dropped);
}

TEST(Pipeline, CanBeWaitedForAndGoOn) {
  Results results;
  Pipeline pipeline(stream_camera(), stream_parts(), make_backend("serial"), to(results));
  pipeline.wait_for_all();
  for (int round = 1; round <= 3; ++round) {
    for (int i = 0; i < 5; ++i) ASSERT_TRUE(pipeline.put(testing::good_frame(i)));
    pipeline.wait_for_all();
    EXPECT_EQ(results.size(), static_cast<std::size_t>(round) * 5);
  }
}

TEST(Pipeline, FramesAreNotCopiedAndAreLetGo) {
  const std::vector<InputFrame> frames = whole_stream();
  const auto owner = std::make_shared<int>(0);
  const std::uint8_t* pixels = frames[0].image.view.data;
  {
    Pipeline pipeline(stream_camera(), stream_parts(), make_backend("serial"),
                      [&](const FramePtr& frame) { EXPECT_EQ(frame->image.view.data, pixels); });
    for (int i = 0; i < 10; ++i) {
      ASSERT_TRUE(pipeline.put({i, i / 30.0, "", {frames[0].image.view, owner}, {}}));
    }
    pipeline.wait_for_all();
  }
  EXPECT_EQ(owner.use_count(), 1);
}

TEST(Pipeline, CountsWhatItsNodesDid) {
  Results results;
  Pipeline pipeline(stream_camera(), stream_parts(), make_backend("serial"), to(results));
  for (const InputFrame& frame : whole_stream()) ASSERT_TRUE(pipeline.put(frame));
  pipeline.wait_for_all();
  const PipelineStatistics statistics = pipeline.statistics();
  EXPECT_EQ(statistics.accepted, static_cast<std::uint64_t>(kStreamFrames));
  EXPECT_EQ(statistics.failed, 2U);
  EXPECT_GE(statistics.searched_again, 1U) << "the cylinder jumps";
  EXPECT_EQ(statistics.latency.count, statistics.delivered);
  EXPECT_GT(statistics.latency.p99_ms, statistics.latency.median_ms / 2);
  std::uint64_t solved = 0;
  for (const NodeStatistics& node : statistics.nodes) {
    if (node.node == "solve") solved = node.busy.count;
    EXPECT_GE(node.busy.max_ms, node.busy.p99_ms);
  }
  EXPECT_EQ(solved, statistics.delivered - statistics.failed + statistics.searched_again);
}

TEST(Pipeline, SeveralRunAtOnceWithoutKnowingOfEachOther) {
  const std::vector<InputFrame> frames = whole_stream();
  std::vector<std::thread> users;
  for (int lag = 1; lag <= 3; ++lag) {
    users.emplace_back([&frames, lag] {
      PipelineOptions options;
      options.lag = lag;
      const auto device = static_cast<unsigned>(lag);
      expect_stream(run(options, make_slow_device(device, 1000), frames),
                    one_at_a_time(frames, static_cast<std::size_t>(lag)));
    });
  }
  for (std::thread& user : users) user.join();
}

TEST(Pipeline, RefusesWhatCannotBeMeant) {
  const auto reason = [](const PipelineOptions& options, std::vector<PartModel> parts = stream_parts()) {
    try {
      const Pipeline pipeline(
          stream_camera(), std::move(parts), make_backend("serial"), [](const FramePtr&) {}, options);
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::kInput);
      return std::string(error.what());
    }
    return std::string("no error");
  };
  PipelineOptions options;
  options.lag = -1;
  EXPECT_THAT(reason(options), HasSubstr("lag is -1"));
  options.lag = 65;
  EXPECT_THAT(reason(options), HasSubstr("lag is 65"));
  options = {};
  options.threads = 257;
  EXPECT_THAT(reason(options), HasSubstr("threads is 257"));
  options = {};
  options.filter.emplace().gate_chi2 = 0;
  EXPECT_THAT(reason(options), HasSubstr("gate_chi2"));
  EXPECT_THAT(reason({}, {}), HasSubstr("no part"));
  EXPECT_THAT(reason({}, {PartModel{}}), HasSubstr("radius"));
}

}  // namespace
}  // namespace cylpose::graph
