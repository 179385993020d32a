#include <oneapi/tbb/task_arena.h>

#include <cylpose/graph/nodes.hpp>
#include <mutex>
#include <utility>

#include "failure.hpp"
#include "span_clock.hpp"

namespace cylpose::graph {
namespace {

// One for all copies that oneTBB makes of the body.
class Detector : public std::enable_shared_from_this<Detector> {
 public:
  using Gateway = DetectNode::gateway_type;

  Detector(Backend& backend, std::vector<PartModel> parts, DetectOptions options, NodeObserver observer)
      : backend_(backend), parts_(std::move(parts)), options_(options), observer_(std::move(observer)) {
    std::string why;
    for (const PartModel& part : parts_) {
      if (!part.is_valid(&why)) throw Error(ErrorKind::kInput, why);
    }
    if (!options_.is_valid(&why)) throw Error(ErrorKind::kInput, "options of the edge detection: " + why);
  }

  void start(const FramePtr& frame, Gateway& gateway) {
    if (frame->failure) {
      gateway.try_put(frame);
      return;
    }
    // Bodies run in the graph's arena only.
    std::call_once(attached_, [this] { arena_.initialize(tbb::attach{}); });
    SpanClock clock(observer_);
    const auto pending = std::make_shared<Pending>(shared_from_this(), gateway, frame);
    if (observer_) pending->started = Clock::now();
    const Roi search = frame->search.empty() ? frame->image.view.bounds() : frame->search;
    gateway.reserve_wait();
    backend_.detect_async({frame->image.view, search, parts_, options_},
                          [pending](std::shared_ptr<DetectionEnd> end) { hand_over(pending, std::move(end)); });
    clock.lap("detect", *frame);
  }

 private:
  // A driver may keep its callback a little longer than the graph lives: by then this is empty.
  struct Pending {
    Pending(std::shared_ptr<Detector> owner, Gateway& to, FramePtr what)
        : detector(std::move(owner)), gateway(to), frame(std::move(what)) {}

    std::shared_ptr<Detector> detector;
    Gateway& gateway;
    FramePtr frame;
    std::shared_ptr<DetectionEnd> end;
    Clock::time_point started;
    Clock::time_point ended;
  };

  // On a driver's thread, where nothing may take long.
  static void hand_over(const std::shared_ptr<Pending>& pending, std::shared_ptr<DetectionEnd> end) {
    // Keeps the arena: what is enqueued may have run, and the graph have ended, before enqueue returns.
    const std::shared_ptr<Detector> detector = pending->detector;
    if (detector->observer_) pending->ended = Clock::now();
    pending->end = std::move(end);
    detector->arena_.enqueue([pending] { finish(*pending); });
  }

  static void finish(Pending& pending) {
    Gateway& gateway = pending.gateway;
    {
      const std::shared_ptr<Detector> detector = std::move(pending.detector);
      const FramePtr frame = std::move(pending.frame);
      detector->collect(*frame, std::exchange(pending.end, nullptr));
      if (detector->observer_) detector->observer_({"device", *frame, pending.started, pending.ended});
      gateway.try_put(frame);
    }
    gateway.release_wait();
  }

  void collect(FrameTask& frame, const std::shared_ptr<DetectionEnd>& end) {
    SpanClock clock(observer_);
    try {
      frame.field = end->field();
    } catch (...) {
      frame.failure = current_failure();
    }
    clock.lap("collect", frame);
  }

  Backend& backend_;
  std::vector<PartModel> parts_;
  DetectOptions options_;
  NodeObserver observer_;
  std::once_flag attached_;
  tbb::task_arena arena_;
};

}  // namespace

DetectNode::DetectNode(tbb::flow::graph& graph, Backend& backend, std::vector<PartModel> parts, DetectOptions options,
                       NodeObserver observer)
    : async_node(graph, tbb::flow::unlimited,
                 [detector = std::make_shared<Detector>(backend, std::move(parts), options, std::move(observer))](
                     const FramePtr& frame, gateway_type& gateway) { detector->start(frame, gateway); }) {}

}  // namespace cylpose::graph
