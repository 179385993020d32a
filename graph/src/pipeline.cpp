#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <cylpose/graph/nodes.hpp>
#include <cylpose/graph/pipeline.hpp>
#include <exception>
#include <mutex>
#include <thread>
#include <utility>

#include "failure.hpp"
#include "intake.hpp"
#include "pipeline_observer.hpp"
#include "search_plan.hpp"
#include "span_clock.hpp"

namespace cylpose::graph {
namespace {

using FrameNode = tbb::flow::function_node<FramePtr, FramePtr>;

void require_valid(const CameraModel& camera, const std::vector<PartModel>& parts, const PipelineOptions& options) {
  std::string why;
  if (!options.is_valid(&why)) throw Error(ErrorKind::kInput, "options of the pipeline: " + why);
  if (!camera.is_valid(&why)) throw Error(ErrorKind::kInput, "camera: " + why);
  if (parts.empty()) throw Error(ErrorKind::kInput, "no part to look for");
  for (const PartModel& part : parts) {
    if (!part.is_valid(&why)) throw Error(ErrorKind::kInput, "part '" + part.name + "': " + why);
  }
}

int lag_of(const PipelineOptions& options) {
  constexpr int kRecordingLag = 3;
  if (options.lag > 0) return options.lag;
  return options.policy == Policy::kAll ? kRecordingLag : 1;
}

// No more than oneTBB has: it would print a warning.
int threads_of(const PipelineOptions& options) {
  const auto most = static_cast<int>(tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism));
  return options.threads > 0 ? std::min(options.threads, most) : tbb::task_arena::automatic;
}

DetectOptions detect_options(const CameraModel& camera, const PipelineOptions& options) {
  DetectOptions detect;
  detect.transfer = camera.transfer;
  detect.with_mask = options.with_stages;
  return detect;
}

std::optional<PoseFilter> filter_of(const CameraModel& camera, const std::vector<PartModel>& parts,
                                    const PipelineOptions& options) {
  if (!options.filter) return std::nullopt;
  return PoseFilter(camera, parts, *options.filter);
}

}  // namespace

class Pipeline::Impl {
 public:
  Impl(CameraModel camera, std::vector<PartModel> parts, Sink sink, const PipelineOptions& options)
      : camera_((require_valid(camera, parts, options), std::move(camera))),
        parts_(std::move(parts)),
        sink_(std::move(sink)),
        options_(options),
        intake_(options.policy, lag_of(options)),
        plan_(camera_, parts_, lag_of(options), filter_of(camera_, parts_, options)),
        observer_(options.trace, Intake::capacity(lag_of(options))),
        arena_(threads_of(options)) {}

  void use(std::unique_ptr<Backend> backend) {
    backend_ = std::move(backend);
    const auto solver = std::make_shared<const PoseSolver>(camera_, parts_, options_.solve);
    build([&] {
      detect_.emplace(*graph_, *backend_, parts_, detect_options(camera_, options_), to_observer_);
      solve_.emplace(*graph_, solver, tbb::flow::unlimited, options_.with_stages, to_observer_);
      retry_.emplace(*graph_);
      make_edge(*detect_, *solve_);
      make_edge(*solve_, *retry_);
      make_edge(tbb::flow::output_port<0>(*retry_), *order_);
      make_edge(tbb::flow::output_port<1>(*retry_), *detect_);
      entrance_ = &*detect_;
    });
  }

  void use(std::shared_ptr<Estimator> estimator) {
    build([&] {
      estimate_.emplace(*graph_, std::move(estimator), parts_.size(), options_.with_stages, to_observer_);
      make_edge(*estimate_, *order_);
      entrance_ = &*estimate_;
    });
  }

  ~Impl() {
    cancel();
    intake_.wait_until_empty();
    if (!helper_.joinable()) return;
    graph_->release_wait();
    helper_.join();
  }
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

  bool put(InputFrame input, bool wait) {
    auto frame = std::make_shared<FrameTask>();
    static_cast<InputFrame&>(*frame) = std::move(input);
    check(*frame);
    if (!intake_.put(frame, wait)) return false;
    start_frames();
    return true;
  }

  void wait_for_all() {
    intake_.wait_until_empty();
    const std::scoped_lock lock(failure_mutex_);
    if (sink_failure_) std::rethrow_exception(std::exchange(sink_failure_, nullptr));
  }

  void cancel() {
    cancelled_ = true;
    intake_.close();
  }

  [[nodiscard]] PipelineStatistics statistics() const {
    const Intake::Counts counts = intake_.counts();
    return {counts.accepted,        counts.dropped,      counts.delivered, failed_.load(),
            searched_again_.load(), observer_.latency(), observer_.nodes()};
  }

 private:
  template <typename MakeStages>
  void build(MakeStages make_stages) {
    // A graph works in the arena in which it was made.
    arena_.execute([&] {
      graph_.emplace();
      order_.emplace(*graph_);
      order_again_.emplace(*graph_);
      take_in_.emplace(*graph_, tbb::flow::serial, [this](const FramePtr& frame) {
        take_in(*frame);
        return frame;
      });
      deliver_.emplace(*graph_, [this](const FramePtr& frame) { deliver(frame); });
      make_edge(*order_, *take_in_);
      // Once more: a serial node starts on the next frame before it hands on the last one.
      make_edge(*take_in_, *order_again_);
      make_edge(*order_again_, *deliver_);
      make_stages();
    });
    // oneTBB has a thread less than there are cores: it counts on the caller, who may have better things to do.
    graph_->reserve_wait();
    helper_ = std::thread([this] { arena_.execute([this] { graph_->wait_for_all(); }); });
  }

  void check(FrameTask& frame) const {
    if (frame.failure) return;
    try {
      require_usable(frame.image.view);
      require_calibrated_size(camera_, frame.image.view);
    } catch (...) {
      frame.failure = current_failure();
    }
  }

  void start_frames() {
    while (const FramePtr frame = intake_.next()) {
      if (backend_) frame->search = plan_.region(*frame);
      entrance_->try_put(frame);
    }
  }

  void take_in(FrameTask& frame) {
    SpanClock clock(to_observer_);
    plan_.take_in(frame);
    clock.lap(options_.filter ? "filter" : "region", frame);
    intake_.solved();
    start_frames();
  }

  void deliver(const FramePtr& frame) {
    const bool wanted = !cancelled_;
    if (wanted) {
      observer_.arrived(*frame);
      SpanClock clock(to_observer_);
      call_sink(frame);
      clock.lap("sink", *frame);
      failed_ += frame->failure ? 1 : 0;
      searched_again_ += frame->searched_again ? 1 : 0;
    }
    observer_.left(*frame);
    intake_.left(wanted);
    start_frames();
  }

  void call_sink(const FramePtr& frame) {
    try {
      sink_(frame);
    } catch (...) {
      {
        const std::scoped_lock lock(failure_mutex_);
        if (!sink_failure_) sink_failure_ = std::current_exception();
      }
      cancel();
    }
  }

  CameraModel camera_;
  std::vector<PartModel> parts_;
  Sink sink_;
  PipelineOptions options_;
  Intake intake_;
  SearchPlan plan_;
  PipelineObserver observer_;
  const NodeObserver to_observer_ = [this](const NodeSpan& span) { observer_.node_span(span); };
  std::atomic<bool> cancelled_ = false;
  std::atomic<std::uint64_t> failed_ = 0;
  std::atomic<std::uint64_t> searched_again_ = 0;
  std::mutex failure_mutex_;
  std::exception_ptr sink_failure_;

  std::unique_ptr<Backend> backend_;  ///< outlives the nodes
  tbb::task_arena arena_;
  std::optional<tbb::flow::graph> graph_;
  std::optional<DetectNode> detect_;
  std::optional<SolveNode> solve_;
  std::optional<RetryNode> retry_;
  std::optional<EstimateNode> estimate_;
  std::optional<OrderNode> order_;
  std::optional<OrderNode> order_again_;
  std::optional<FrameNode> take_in_;
  std::optional<SinkNode> deliver_;
  tbb::flow::receiver<FramePtr>* entrance_ = nullptr;
  std::thread helper_;
};

bool PipelineOptions::is_valid(std::string* why) const {
  constexpr int kMostLag = 64;
  constexpr int kMostThreads = 256;
  const auto refuse = [why](std::string reason) {
    if (why != nullptr) *why = std::move(reason);
    return false;
  };
  if (lag < 0 || lag > kMostLag) {
    return refuse("lag is " + std::to_string(lag) + "; it must be 0 (by the policy) to " + std::to_string(kMostLag));
  }
  if (threads < 0 || threads > kMostThreads) {
    return refuse("threads is " + std::to_string(threads) + "; it must be 0 (one per core) to " +
                  std::to_string(kMostThreads));
  }
  return solve.is_valid(why) && (!filter || filter->is_valid(why));
}

Pipeline::Pipeline(CameraModel camera, std::vector<PartModel> parts, std::unique_ptr<Backend> backend, Sink sink,
                   const PipelineOptions& options)
    : impl_(std::make_unique<Impl>(std::move(camera), std::move(parts), std::move(sink), options)) {
  impl_->use(std::move(backend));
}

Pipeline::Pipeline(CameraModel camera, std::vector<PartModel> parts, std::unique_ptr<Estimator> estimator, Sink sink,
                   const PipelineOptions& options)
    : impl_(std::make_unique<Impl>(std::move(camera), std::move(parts), std::move(sink), options)) {
  impl_->use(std::shared_ptr<Estimator>(std::move(estimator)));
}

Pipeline::~Pipeline() = default;

bool Pipeline::try_put(InputFrame frame) {
  return impl_->put(std::move(frame), false);
}

bool Pipeline::put(InputFrame frame) {
  return impl_->put(std::move(frame), true);
}

void Pipeline::wait_for_all() {
  impl_->wait_for_all();
}

void Pipeline::cancel() {
  impl_->cancel();
}

PipelineStatistics Pipeline::statistics() const {
  return impl_->statistics();
}

}  // namespace cylpose::graph
