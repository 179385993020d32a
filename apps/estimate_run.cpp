#include "estimate_run.hpp"

#include <fmt/format.h>

#include <chrono>
#include <cylpose/debug_pictures.hpp>
#include <cylpose/error.hpp>
#include <cylpose/image_cv.hpp>
#include <cylpose/overlay.hpp>
#include <optional>
#include <string_view>

#include "interrupt.hpp"

namespace cylpose::apps {
namespace {

using Clock = std::chrono::steady_clock;

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

class Run {
 public:
  Run(FrameSource& source, Estimator& estimator, const CameraModel& camera, std::span<const PartModel> parts,
      const RunSinks& sinks)
      : source_(source), estimator_(estimator), camera_(camera), parts_(parts), sinks_(sinks) {}

  RunSummary run() {
    const Clock::time_point start = Clock::now();
    Stopwatch watch;
    while (!InterruptGuard::requested()) {
      const std::optional<Frame> frame = source_.next();
      if (!frame) break;
      times_ = {{"decode", watch.lap_ms()}};
      process(*frame, &watch);
      if (sinks_.timing != nullptr) sinks_.timing->add(times_);
      sinks_.progress->update(++summary_.frames);
      (void)watch.lap_ms();  // drawing the progress bar belongs to no stage
    }
    summary_.interrupted = InterruptGuard::requested();
    summary_.seconds = std::chrono::duration<double>(Clock::now() - start).count();
    return summary_;
  }

 private:
  void process(const Frame& frame, Stopwatch* watch) {
    StageTrace trace;
    const FrameEstimate estimate = estimated(frame, &trace);
    times_.insert(times_.end(), estimate.times.begin(), estimate.times.end());
    times_.push_back({"all stages", watch->lap_ms()});
    sinks_.poses->write(frame.index, frame.timestamp_s, estimate);
    times_.push_back({"write", watch->lap_ms()});
    if (frame.error.empty()) write_pictures(frame, estimate, trace, watch);
    count(estimate);
  }

  FrameEstimate estimated(const Frame& frame, StageTrace* trace) {
    if (!frame.error.empty()) {
      sinks_.progress->message(frame.error);
      ++summary_.unreadable;
      PoseEstimate none;
      none.reason = frame.error;
      return {{}, std::vector<PoseEstimate>(parts_.size(), none), {}};
    }
    try {
      return estimator_.estimate(view_of(frame.image), sinks_.debug != nullptr ? trace : nullptr);
    } catch (const Error& error) {
      throw Error(error.kind(), fmt::format("{}: {}", frame.name, error.what()));
    }
  }

  void write_pictures(const Frame& frame, const FrameEstimate& estimate, const StageTrace& trace, Stopwatch* watch) {
    if (sinks_.overlay != nullptr) {
      sinks_.overlay->write(frame.index, overlay(frame.image, camera_, parts_, estimate));
      times_.push_back({"overlay", watch->lap_ms()});
    }
    if (sinks_.debug != nullptr) {
      for (const DebugPicture& picture : debug_pictures(frame.image, camera_, parts_, estimate, trace)) {
        sinks_.debug->write(frame.index, picture.name, picture.picture);
      }
      times_.push_back({"debug pictures", watch->lap_ms()});
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
  Estimator& estimator_;
  const CameraModel& camera_;
  std::span<const PartModel> parts_;
  const RunSinks& sinks_;
  std::vector<StageTime> times_;  ///< of the frame at hand
  RunSummary summary_;
};

}  // namespace

RunSummary run_estimation(FrameSource& source, Estimator& estimator, const CameraModel& camera,
                          std::span<const PartModel> parts, const RunSinks& sinks) {
  return Run(source, estimator, camera, parts, sinks).run();
}

}  // namespace cylpose::apps
