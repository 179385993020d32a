// A recording in memory as an endless stream, timed in batches.
#pragma once

#include <benchmark/benchmark.h>
#include <sys/resource.h>

#include <cylpose/graph/frame_task.hpp>

#include "scenes.hpp"

namespace cylpose::bench {

// Frames between two waits for the pipeline to empty: its first and last frames keep fewer cores busy.
inline constexpr int kBatch = 100;

// To and fro, so that it has no jump and no end.
inline graph::InputFrame frame_of(const Recording& recording, int index) {
  const int last = static_cast<int>(recording.pictures.size()) - 1;
  const int place = index % (2 * last);
  const cv::Mat& picture = recording.pictures[static_cast<std::size_t>(place <= last ? place : 2 * last - place)];
  return {index, index / 30.0, "", graph::shared(picture), {}};
}

inline double processor_seconds() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  const auto seconds = [](const timeval& time) {
    return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
  };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

// Time and processor time of a frame, whatever the batch.
template <typename Batch>
void time_batches(benchmark::State& state, Batch batch) {
  batch();
  const double processor = processor_seconds();
  while (state.KeepRunningBatch(kBatch)) batch();
  state.counters["processor_ms"] = 1e3 * (processor_seconds() - processor) / static_cast<double>(state.iterations());
}

}  // namespace cylpose::bench
