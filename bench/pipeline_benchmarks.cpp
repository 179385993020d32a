// A recording in memory through the pipeline, beside the same frames one at a time.
#include <algorithm>
#include <cylpose/estimator.hpp>
#include <cylpose/graph/pipeline.hpp>
#include <exception>
#include <string>
#include <thread>

#include "batches.hpp"
#include "benchmarks.hpp"

namespace cylpose::bench {
namespace {

using graph::Clock;
using graph::Pipeline;

std::uint64_t found_in(const std::vector<PoseEstimate>& parts) {
  return static_cast<std::uint64_t>(
      std::ranges::count(parts, PoseStatus::kOk, [](const PoseEstimate& part) { return part.status; }));
}

void one_at_a_time(const Recording& recording, benchmark::State& state) {
  const auto estimator = make_estimator("default", recording.camera, recording.parts, "opencl");
  int next = 0;
  std::uint64_t found = 0;
  time_batches(state, [&] {
    for (int i = 0; i < kBatch; ++i) {
      found += found_in(estimator->estimate(frame_of(recording, next++).image.view).parts);
    }
  });
  state.counters["found"] = static_cast<double>(found) / next;
}

void pipeline(const Recording& recording, const graph::PipelineOptions& options, benchmark::State& state) {
  int next = 0;
  std::uint64_t found = 0;
  Pipeline stream(
      recording.camera, recording.parts, make_backend("opencl"),
      [&](const graph::FramePtr& frame) { found += found_in(frame->estimate.parts); }, options);
  time_batches(state, [&] {
    for (int i = 0; i < kBatch; ++i) stream.put(frame_of(recording, next++));
    stream.wait_for_all();
  });
  state.counters["found"] = static_cast<double>(found) / next;
  state.counters["p99_ms"] = stream.statistics().latency.p99_ms;
}

// A camera twice as fast as the live pipeline can follow: what the newest poses are behind.
void overload(const Recording& recording, benchmark::State& state) {
  graph::PipelineOptions options;
  options.policy = graph::Policy::kLatest;
  double frame_time = 0;
  for (const bool warm : {false, true}) {  // the first time builds programs
    Pipeline stream(
        recording.camera, recording.parts, make_backend("opencl"), [](const auto&) {}, options);
    const Clock::time_point start = Clock::now();
    for (int i = 0; i < kBatch; ++i) {
      stream.put(frame_of(recording, i));
      stream.wait_for_all();
    }
    if (warm) frame_time = std::chrono::duration<double>(Clock::now() - start).count() / kBatch;
  }
  const auto period = std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(frame_time / 2));
  for (auto _ : state) {
    Pipeline stream(
        recording.camera, recording.parts, make_backend("opencl"), [](const auto&) {}, options);
    Clock::time_point due = Clock::now();
    const Clock::time_point start = due;
    for (int i = 0; i < 10 * kBatch; ++i) {
      stream.put(frame_of(recording, i));
      due += period;
      std::this_thread::sleep_until(due);
    }
    stream.wait_for_all();
    const graph::PipelineStatistics statistics = stream.statistics();
    const double span = std::chrono::duration<double>(Clock::now() - start).count();
    const double live_frame_ms = 1e3 * span / static_cast<double>(statistics.delivered);
    state.SetIterationTime(1e-3 * statistics.latency.p99_ms);
    state.counters["frame_ms"] = live_frame_ms;
    state.counters["p99_frames"] = statistics.latency.p99_ms / live_frame_ms;
    state.counters["dropped"] = static_cast<double>(statistics.dropped) / static_cast<double>(statistics.accepted);
  }
}

// Stages that take next to nothing.
class IdleBackend final : public Backend {
 public:
  [[nodiscard]] std::string_view name() const override { return "idle"; }
  [[nodiscard]] EdgeField detect(const ImageView& image, const Roi& search, std::span<const PartModel> parts,
                                 const DetectOptions& options) override {
    EdgeField field;
    field.searched = usable_search(image, search, options);
    field.parts.resize(parts.size());
    return field;
  }
};

void overhead_without(const Recording& recording, benchmark::State& state) {
  const auto estimator = make_estimator(recording.camera, recording.parts, std::make_unique<IdleBackend>());
  int next = 0;
  time_batches(state, [&] {
    for (int i = 0; i < kBatch; ++i) {
      benchmark::DoNotOptimize(estimator->estimate(frame_of(recording, next++).image.view));
    }
  });
}

void overhead_with(const Recording& recording, benchmark::State& state) {
  int next = 0;
  Pipeline stream(recording.camera, recording.parts, std::make_unique<IdleBackend>(), [](const auto&) {});
  time_batches(state, [&] {
    for (int i = 0; i < kBatch; ++i) stream.put(frame_of(recording, next++));
    stream.wait_for_all();
  });
}

}  // namespace

void register_pipeline_benchmarks(const Register& add) {
  const auto add_guarded = [&](const std::string& name, std::function<void(benchmark::State&)> run) {
    benchmark::internal::Benchmark* added = add(name, [run = std::move(run)](benchmark::State& state) {
      try {
        run(state);
      } catch (const std::exception& error) {
        // An error of this benchmark; the others go on.
        state.SkipWithError(error.what());
      }
    });
    return added;
  };
  const auto add_timed = [&](const std::string& name, std::function<void(benchmark::State&)> run) {
    benchmark::internal::Benchmark* added = add_guarded(name, std::move(run));
    if (added != nullptr) added->UseRealTime();
  };
  add_timed("pipeline/one_at_a_time", [](auto& state) { one_at_a_time(recording(), state); });
  for (const int lag : {1, 2, 3, 4}) {
    add_timed("pipeline/lag_" + std::to_string(lag), [lag](auto& state) {
      graph::PipelineOptions options;
      options.lag = lag;
      pipeline(recording(), options, state);
    });
  }
  add_timed("pipeline/filter", [](auto& state) {
    graph::PipelineOptions options;
    options.filter.emplace();
    pipeline(recording(), options, state);
  });
  // One overloaded second says it all; the time is the percentile.
  benchmark::internal::Benchmark* live =
      add_guarded("pipeline/overload_p99", [](auto& state) { overload(recording(), state); });
  if (live != nullptr) live->UseManualTime()->Iterations(1);
  add_timed("pipeline/overhead/without", [](auto& state) { overhead_without(recording(), state); });
  add_timed("pipeline/overhead/with", [](auto& state) { overhead_with(recording(), state); });
}

}  // namespace cylpose::bench
