#include <algorithm>
#include <cylpose/graph/nodes.hpp>
#include <utility>

#include "failure.hpp"
#include "span_clock.hpp"

namespace cylpose::graph {
namespace {

FramePtr task_of(Frame frame, std::uint64_t sequence) {
  auto task = std::make_shared<FrameTask>();
  static_cast<InputFrame&>(*task) = input_of(std::move(frame));
  task->sequence = sequence;
  task->entered = Clock::now();
  return task;
}

bool all_found(const FrameTask& frame) {
  return std::ranges::all_of(frame.estimate.parts,
                             [](const PoseEstimate& part) { return part.status != PoseStatus::kNone; });
}

bool is_whole(const FrameTask& frame) {
  return frame.search.empty() || intersection(frame.search, frame.image.view.bounds()) == frame.image.view.bounds();
}

}  // namespace

InputFrame input_of(Frame frame) {
  InputFrame input{frame.index, frame.timestamp_s, std::move(frame.name), {}, {}};
  if (frame.error.empty()) {
    input.image = shared(std::move(frame.image));
  } else {
    input.failure = Error(ErrorKind::kInput, frame.error);
  }
  return input;
}

SourceNode::SourceNode(tbb::flow::graph& graph, std::unique_ptr<FrameSource> frames)
    : input_node(graph,
                 [frames = std::shared_ptr(std::move(frames)),
                  sequence = std::uint64_t{0}](tbb::flow_control& control) mutable -> FramePtr {
                   std::optional<Frame> frame = frames->next();
                   if (frame) return task_of(std::move(*frame), sequence++);
                   control.stop();
                   return nullptr;
                 }) {}

PushNode::PushNode(tbb::flow::graph& graph)
    : function_node(graph, tbb::flow::serial, [sequence = std::uint64_t{0}](const FramePtr& frame) mutable {
        frame->sequence = sequence++;
        frame->entered = Clock::now();
        return frame;
      }) {}

SolveNode::SolveNode(tbb::flow::graph& graph, std::shared_ptr<const PoseSolver> solver, std::size_t concurrency,
                     bool with_stages, NodeObserver observer)
    : function_node(
          graph, concurrency,
          [solver = std::move(solver), with_stages, observer = std::move(observer)](const FramePtr& frame) {
            FrameEstimate& estimate = frame->estimate;
            if (!frame->failure) {
              SpanClock clock(observer);
              try {
                estimate.searched = frame->field.searched;
                estimate.times.insert(estimate.times.end(), frame->field.times.begin(), frame->field.times.end());
                estimate.parts = solver->solve(frame->field, with_stages ? &frame->stages : nullptr, &estimate.times);
              } catch (...) {
                frame->failure = current_failure();
              }
              clock.lap("solve", *frame);
            }
            if (frame->failure) estimate.parts = no_poses(*frame, solver->parts().size());
            return frame;
          }) {}

RetryNode::RetryNode(tbb::flow::graph& graph)
    : multifunction_node(graph, tbb::flow::unlimited, [](const FramePtr& frame, output_ports_type& ports) {
        if (frame->failure || is_whole(*frame) || all_found(*frame)) {
          std::get<0>(ports).try_put(frame);
          return;
        }
        frame->search = {};
        frame->searched_again = true;
        std::get<1>(ports).try_put(frame);
      }) {}

OrderNode::OrderNode(tbb::flow::graph& graph)
    : sequencer_node(graph, [](const FramePtr& frame) { return static_cast<std::size_t>(frame->sequence); }) {}

EstimateNode::EstimateNode(tbb::flow::graph& graph, std::shared_ptr<Estimator> estimator, std::size_t parts,
                           bool with_stages, NodeObserver observer)
    : function_node(graph, tbb::flow::serial,
                    [estimator = std::move(estimator), parts, with_stages,
                     observer = std::move(observer)](const FramePtr& frame) {
                      if (!frame->failure) {
                        SpanClock clock(observer);
                        try {
                          frame->estimate =
                              estimator->estimate(frame->image.view, with_stages ? &frame->stages : nullptr);
                        } catch (...) {
                          frame->failure = current_failure();
                        }
                        clock.lap("estimate", *frame);
                      }
                      if (frame->failure) frame->estimate.parts = no_poses(*frame, parts);
                      return frame;
                    }) {}

SinkNode::SinkNode(tbb::flow::graph& graph, Sink sink, NodeObserver observer)
    : function_node(graph, tbb::flow::serial,
                    [sink = std::move(sink), observer = std::move(observer)](const FramePtr& frame) {
                      SpanClock clock(observer);
                      sink(frame);
                      clock.lap("sink", *frame);
                      return tbb::flow::continue_msg();
                    }) {}

}  // namespace cylpose::graph
