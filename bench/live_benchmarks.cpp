// What the live page costs the pipeline: the same stream without it, with it, and with somebody who looks.
#include <cylpose/graph/pipeline.hpp>
#include <exception>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "batches.hpp"
#include "benchmarks.hpp"
#include "live/live_page.hpp"
#include "live_viewer.hpp"

namespace cylpose::bench {
namespace {

enum class Watched { kNot, kByNobody, kBySomebody };

void stream(const Recording& recording, Watched watched, benchmark::State& state) {
  apps::LiveState live(recording.camera, recording.parts, std::nullopt, {});
  std::optional<apps::LivePage> page;
  if (watched != Watched::kNot) {
    page.emplace(live, "127.0.0.1", 0);
    page->start();
  }
  graph::Pipeline pipeline(recording.camera, recording.parts, make_backend("opencl"),
                           [&](const graph::FramePtr& frame) {
                             if (page) live.offer(frame);
                           });
  const auto attached = live.attach(pipeline, {});
  std::optional<LiveViewer> viewer;
  if (watched == Watched::kBySomebody) viewer.emplace(page->port());
  int next = 0;
  time_batches(state, [&] {
    for (int i = 0; i < kBatch; ++i) pipeline.put(frame_of(recording, next++));
    pipeline.wait_for_all();
  });
  // None at all has no coefficient of variation: the JSON file would hold what JSON cannot say.
  if (page && page->pictures_made() > 0) state.counters["pictures"] = static_cast<double>(page->pictures_made());
}

}  // namespace

void register_live_benchmarks(const Register& add) {
  const auto add_one = [&](const std::string& name, Watched watched) {
    benchmark::internal::Benchmark* added = add("pipeline/live/" + name, [watched](benchmark::State& state) {
      try {
        stream(recording(), watched, state);
      } catch (const std::exception& error) {
        // An error of this benchmark; the others go on.
        state.SkipWithError(error.what());
      }
    });
    if (added != nullptr) added->UseRealTime();
  };
  add_one("without", Watched::kNot);
  add_one("no_viewer", Watched::kByNobody);
  add_one("viewer", Watched::kBySomebody);
}

}  // namespace cylpose::bench
