// What a pipeline keeps of its nodes' spans: figures always, a trace on request.
#pragma once

#include <array>
#include <cylpose/graph/frame_task.hpp>
#include <cylpose/graph/statistics.hpp>
#include <cylpose/graph/trace.hpp>
#include <memory>
#include <string_view>
#include <vector>

namespace cylpose::graph {

class PipelineObserver {
 public:
  /// `lanes`: frames inside at most.
  PipelineObserver(std::shared_ptr<Trace> trace, std::uint64_t lanes) : trace_(std::move(trace)), lanes_(lanes) {}

  void node_span(const NodeSpan& span);
  /// A frame on its way to the sink.
  void arrived(const FrameTask& frame);
  /// A frame that the sink has seen.
  void left(const FrameTask& frame);

  [[nodiscard]] DurationStatistics latency() const { return latency_.statistics(); }
  [[nodiscard]] std::vector<NodeStatistics> nodes() const;

 private:
  void trace_device(const NodeSpan& span);

  static constexpr std::array<std::string_view, 8> kNodes{"detect",   "device", "collect", "solve",
                                                          "estimate", "region", "filter",  "sink"};

  std::shared_ptr<Trace> trace_;
  std::uint64_t lanes_;
  DurationHistogram latency_;
  std::array<DurationHistogram, kNodes.size()> busy_;
};

}  // namespace cylpose::graph
