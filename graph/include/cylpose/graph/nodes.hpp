// The stages as nodes for any tbb::flow::graph. All take and give a FramePtr, so that nodes of your own fit in anywhere
// between them: make_edge(source, detect); make_edge(detect, solve); ... (examples/embed_nodes). Pipeline
// (pipeline.hpp) is made of the same nodes, for those who need no graph of their own.
//
// Nodes turn what goes wrong with a frame into its `failure`; only sources and sinks throw, and a throw cancels the
// graph and comes out of graph::wait_for_all, as everywhere in oneTBB.
#pragma once

#include <oneapi/tbb/flow_graph.h>

#include <cylpose/backend.hpp>
#include <cylpose/frame_source.hpp>
#include <cylpose/graph/frame_task.hpp>
#include <cylpose/graph/sinks.hpp>
#include <cylpose/part.hpp>
#include <cylpose/pose_solver.hpp>
#include <memory>
#include <tuple>
#include <vector>

namespace cylpose::graph {

/// A source's frame as the graph takes it; its error becomes the failure.
[[nodiscard]] InputFrame input_of(Frame frame);

/// Frames from files, videos and cameras; numbers them. Starts with activate(). What FrameSource::next throws (a camera
/// that fails) cancels the graph.
class SourceNode : public tbb::flow::input_node<FramePtr> {
 public:
  SourceNode(tbb::flow::graph& graph, std::unique_ptr<FrameSource> frames);
};

/// Frames that the program pushes, from one or more threads: try_put(std::make_shared<FrameTask>(...)). Numbers them in
/// the order of arrival.
class PushNode : public tbb::flow::function_node<FramePtr, FramePtr> {
 public:
  explicit PushNode(tbb::flow::graph& graph);
};

/// Fills in FrameTask::field by a backend. No thread waits for a device: its end hands the frame to the graph's arena.
/// The backend must outlive the graph's work; it is used for several frames at once.
class DetectNode : public tbb::flow::async_node<FramePtr, FramePtr> {
 public:
  /// Throws Error(kInput) for invalid parts or options. Spans: "detect" (start), "device" (until its end), "collect".
  DetectNode(tbb::flow::graph& graph, Backend& backend, std::vector<PartModel> parts, DetectOptions options = {},
             NodeObserver observer = {});
};

/// Fills in FrameTask::estimate from FrameTask::field.
class SolveNode : public tbb::flow::function_node<FramePtr, FramePtr> {
 public:
  /// `concurrency`: frames at once, or tbb::flow::unlimited. With `with_stages` FrameTask::stages is filled in too
  /// (masks need DetectOptions::with_mask). Span: "solve".
  SolveNode(tbb::flow::graph& graph, std::shared_ptr<const PoseSolver> solver, std::size_t concurrency,
            bool with_stages = false, NodeObserver observer = {});
};

/// Sends a frame whose parts were not all found in FrameTask::search back, to be searched as a whole: output_port<1>,
/// for an edge to the DetectNode. All others leave by output_port<0>.
class RetryNode : public tbb::flow::multifunction_node<FramePtr, std::tuple<FramePtr, FramePtr>> {
 public:
  explicit RetryNode(tbb::flow::graph& graph);
};

/// Brings frames back into the order of FrameTask::sequence, whatever the concurrency before. Belongs directly before
/// each node that needs the order: oneTBB's nodes, the serial ones too, may hand on in another order than they work in.
/// As all of oneTBB's buffers it gives each frame to one successor.
class OrderNode : public tbb::flow::sequencer_node<FramePtr> {
 public:
  explicit OrderNode(tbb::flow::graph& graph);
};

/// A whole Estimator as one node, for methods that are not divided into stages; one frame at a time.
class EstimateNode : public tbb::flow::function_node<FramePtr, FramePtr> {
 public:
  /// `parts`: how many parts the estimator looks for. Span: "estimate".
  EstimateNode(tbb::flow::graph& graph, std::shared_ptr<Estimator> estimator, std::size_t parts,
               bool with_stages = false, NodeObserver observer = {});
};

/// Calls `sink` frame by frame; put an OrderNode directly before it where order matters. What the sink throws cancels
/// the graph. Its messages tell that a frame is done, for the decrementer of a limiter_node.
class SinkNode : public tbb::flow::function_node<FramePtr, tbb::flow::continue_msg> {
 public:
  /// Span: "sink".
  SinkNode(tbb::flow::graph& graph, Sink sink, NodeObserver observer = {});
};

}  // namespace cylpose::graph
