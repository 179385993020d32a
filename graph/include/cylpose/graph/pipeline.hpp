// Push frames, get poses in order: the assembled graph.
#pragma once

#include <cylpose/backend.hpp>
#include <cylpose/camera.hpp>
#include <cylpose/estimator.hpp>
#include <cylpose/graph/frame_task.hpp>
#include <cylpose/graph/sinks.hpp>
#include <cylpose/graph/statistics.hpp>
#include <cylpose/graph/trace.hpp>
#include <cylpose/part.hpp>
#include <cylpose/pose_filter.hpp>
#include <cylpose/pose_solver.hpp>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace cylpose::graph {

enum class Policy {
  kAll,     ///< recordings: every frame is done, put waits for room
  kLatest,  ///< live: one frame waits at most, a newer one takes its place, and the older one is dropped and counted
};

struct PipelineOptions {
  Policy policy = Policy::kAll;
  /// Frames at work at once: frame k is searched where the results up to frame k - lag say. More keeps more cores busy;
  /// the search region is older, and frames take longer from put to sink. 1 gives the poses of Estimator::estimate to
  /// the last bit; any lag gives the same poses on every machine and at every speed. Range 0..64; 0 means 1 with
  /// kLatest and 3 with kAll.
  int lag = 0;
  /// Threads that work on frames, besides those of the backend's driver. Range 0..256; 0 means one per core;
  /// no more than oneTBB may use in this process (tbb::global_control).
  int threads = 0;
  SolveOptions solve;
  /// Filter poses over time: coasting through occlusions with status `predicted`, and its prediction as search region.
  std::optional<FilterOptions> filter;
  /// Fill in FrameTask::stages, for debug pictures. Costs a mask per part and frame.
  bool with_stages = false;
  /// Records frames, nodes and, where the backend measures them (OpenclOptions::profile), device commands.
  std::shared_ptr<Trace> trace;

  [[nodiscard]] bool is_valid(std::string* why) const;
};

/// One stream of one camera. Several cameras are several pipelines; they share nothing but oneTBB's threads.
///
/// The sink is called with every frame that was accepted and not dropped, in the order of acceptance, one at a time,
/// from a thread of the pipeline. It may call try_put, cancel and statistics; put and wait_for_all would wait for
/// itself. When it throws, the pipeline is cancelled and wait_for_all throws that exception.
///
/// A frame that cannot be used (another size than the calibration, no pixels, a device that failed) is delivered with
/// FrameTask::failure set; the stream goes on.
class Pipeline {
 public:
  /// Throws Error(kInput) for an invalid camera, parts or options.
  Pipeline(CameraModel camera, std::vector<PartModel> parts, std::unique_ptr<Backend> backend, Sink sink,
           const PipelineOptions& options = {});

  /// Around an estimator that is not divided into stages (`make_estimator("thesis", ...)`): one frame at a time, with
  /// search regions of its own; what comes before and after it overlaps. `options.solve` has no meaning.
  Pipeline(CameraModel camera, std::vector<PartModel> parts, std::unique_ptr<Estimator> estimator, Sink sink,
           const PipelineOptions& options = {});

  /// Cancels and waits for the frames under way. For a graceful end call wait_for_all before.
  ~Pipeline();
  Pipeline(const Pipeline&) = delete;
  Pipeline& operator=(const Pipeline&) = delete;

  /// Hands a frame over; the pixels are not copied. False, and the frame is not taken, when there is no room for it
  /// (Policy::kAll) or after cancel. Any thread.
  bool try_put(InputFrame frame);

  /// The same, but waits for room. False only after cancel.
  bool put(InputFrame frame);

  /// Waits until all accepted frames have been delivered or dropped. Frames may be put afterwards. Throws what the sink
  /// threw, once.
  void wait_for_all();

  /// Drops what waits and what is under way: the sink is not called any more once this has returned, except for a call
  /// that is running. Does not wait; nothing can be put from now on.
  void cancel();

  [[nodiscard]] PipelineStatistics statistics() const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace cylpose::graph
