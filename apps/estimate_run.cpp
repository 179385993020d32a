#include "estimate_run.hpp"

#include <fmt/format.h>

#include <chrono>
#include <cylpose/debug_pictures.hpp>
#include <cylpose/error.hpp>
#include <cylpose/graph/nodes.hpp>
#include <cylpose/overlay.hpp>
#include <mutex>
#include <optional>
#include <thread>

#include "interrupt.hpp"

namespace cylpose::apps {
namespace {

using graph::Clock;
using graph::FramePtr;

/// Measures what comes between its calls.
class Stopwatch {
 public:
  double lap_ms() {
    const Clock::time_point now = Clock::now();
    const double milliseconds = std::chrono::duration<double, std::milli>(now - start_).count();
    start_ = now;
    return milliseconds;
  }

 private:
  Clock::time_point start_ = Clock::now();
};

/// Reads on the calling thread; all else happens on the pipeline's, until that has been waited for.
class Run {
 public:
  Run(FrameSource& source, const CameraModel& camera, std::span<const PartModel> parts, const RunSinks& sinks)
      : source_(source), camera_(camera), parts_(parts), sinks_(sinks) {}

  RunSummary run(const MakePipeline& make_pipeline, bool live) {
    const auto pipeline = make_pipeline([this](const FramePtr& frame) { process(frame); });
    std::optional<LiveState::Attachment> watched;
    if (sinks_.live != nullptr) watched.emplace(sinks_.live->attach(*pipeline, sinks_.cluster));
    const Clock::time_point start = Clock::now();
    Stopwatch watch;
    while (!InterruptGuard::requested()) {
      std::optional<Frame> frame = source_.next();
      if (!frame) break;
      add_times({{"decode", watch.lap_ms()}});
      if (live) std::this_thread::sleep_until(start + seconds(frame->timestamp_s));
      if (!pipeline->put(graph::input_of(std::move(*frame)))) break;
      if (sinks_.window != nullptr && !sinks_.window->update()) break;
      (void)watch.lap_ms();  // waiting for room belongs to no stage
    }
    pipeline->wait_for_all();
    if (sinks_.live != nullptr) {
      sinks_.live->settle();
      for (const std::string& warning : source_.warnings()) sinks_.live->tell(warning);
    }
    if (sinks_.window != nullptr) (void)sinks_.window->update();
    summary_.interrupted = InterruptGuard::requested();
    summary_.seconds = std::chrono::duration<double>(Clock::now() - start).count();
    summary_.pipeline = pipeline->statistics();
    summary_.dropped = static_cast<std::int64_t>(summary_.pipeline.dropped);
    return summary_;
  }

 private:
  static Clock::duration seconds(double value) {
    return std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(value));
  }

  void add_times(const std::vector<StageTime>& times) {
    const std::scoped_lock lock(timing_mutex_);
    if (sinks_.timing != nullptr) sinks_.timing->add(times);
    if (sinks_.report != nullptr) sinks_.report->add_times(times);
  }

  void process(const FramePtr& task) {
    const graph::FrameTask& frame = *task;
    std::vector<StageTime> times = frame.estimate.times;
    const double milliseconds = std::chrono::duration<double, std::milli>(Clock::now() - frame.entered).count();
    times.push_back({"in the pipeline", milliseconds});
    require_usable_frame(frame);
    if (sinks_.report != nullptr) sinks_.report->add(as_read(frame), frame.estimate, milliseconds);
    Stopwatch watch;
    sinks_.poses->write(frame.id, frame.timestamp_s,
                        sinks_.extrinsics != nullptr ? in_body(frame.estimate, *sinks_.extrinsics) : frame.estimate);
    times.push_back({"write", watch.lap_ms()});
    if (!frame.failure) write_pictures(frame, &watch, &times);
    add_times(times);
    if (sinks_.live != nullptr) sinks_.live->offer(task);
    count(frame.estimate);
    sinks_.progress->update(++summary_.frames);
  }

  // A file that cannot be read is one frame's trouble; what fails later would fail for the next frame, too.
  void require_usable_frame(const graph::FrameTask& frame) {
    if (!frame.failure) return;
    if (frame.image.view.data != nullptr) {
      throw Error(frame.failure->kind(), fmt::format("{}: {}", frame.name, frame.failure->what()));
    }
    sinks_.progress->message(frame.failure->what());
    if (sinks_.live != nullptr) sinks_.live->tell(frame.failure->what());
    ++summary_.unreadable;
  }

  static Frame as_read(const graph::FrameTask& frame) {
    return {frame.id, frame.timestamp_s, frame.name, frame.failure ? cv::Mat() : mat_of(frame.image.view),
            frame.failure ? frame.failure->what() : ""};
  }

  void write_pictures(const graph::FrameTask& frame, Stopwatch* watch, std::vector<StageTime>* times) {
    const cv::Mat image = mat_of(frame.image.view);
    if (sinks_.overlay != nullptr || sinks_.window != nullptr) {
      const cv::Mat picture = overlay(image, camera_, parts_, frame.estimate);
      if (sinks_.overlay != nullptr) sinks_.overlay->write(frame.id, picture);
      if (sinks_.window != nullptr) sinks_.window->offer(picture);
      times->push_back({"overlay", watch->lap_ms()});
    }
    if (sinks_.debug != nullptr) {
      for (const DebugPicture& picture : debug_pictures(image, camera_, parts_, frame.estimate, frame.stages)) {
        sinks_.debug->write(frame.id, picture.name, picture.picture);
      }
      times->push_back({"debug pictures", watch->lap_ms()});
    }
  }

  void count(const FrameEstimate& estimate) {
    for (const PoseEstimate& part : estimate.parts) {
      ++summary_.poses;
      if (part.status != PoseStatus::kOk) continue;
      ++summary_.found;
      summary_.rms_px.push_back(part.rms_px);
    }
  }

  FrameSource& source_;
  const CameraModel& camera_;
  std::span<const PartModel> parts_;
  const RunSinks& sinks_;
  std::mutex timing_mutex_;
  RunSummary summary_;
};

}  // namespace

RunSummary run_estimation(FrameSource& source, const MakePipeline& make_pipeline, const CameraModel& camera,
                          std::span<const PartModel> parts, const RunSinks& sinks, bool live) {
  return Run(source, camera, parts, sinks).run(make_pipeline, live);
}

}  // namespace cylpose::apps
