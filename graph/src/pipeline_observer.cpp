#include "pipeline_observer.hpp"

#include <algorithm>
#include <iterator>

namespace cylpose::graph {
namespace {

Clock::duration milliseconds(double value) {
  return std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double, std::milli>(value));
}

}  // namespace

void PipelineObserver::node_span(const NodeSpan& span) {
  const auto node = static_cast<std::size_t>(std::distance(kNodes.begin(), std::ranges::find(kNodes, span.node)));
  busy_[node].add(span.end - span.start);
  if (!trace_) return;
  if (span.node == "device") {
    trace_device(span);
  } else {
    trace_->span(span.node, span.frame.id, span.start, span.end);
  }
}

void PipelineObserver::trace_device(const NodeSpan& span) {
  const std::uint64_t lane = span.frame.sequence % lanes_;
  trace_->span("device", lane, span.node, span.frame.id, span.start, span.end);
  for (const StageTime& command : span.frame.field.times) {
    if (command.before_end_ms <= 0) continue;  // no command of a device
    const Clock::time_point start = span.end - milliseconds(command.before_end_ms);
    trace_->span("commands", lane, command.stage, span.frame.id, start, start + milliseconds(command.milliseconds));
  }
}

void PipelineObserver::arrived(const FrameTask& frame) {
  latency_.add(Clock::now() - frame.entered);
}

void PipelineObserver::left(const FrameTask& frame) {
  if (trace_) trace_->span("frame", frame.sequence % lanes_, "frame", frame.id, frame.entered, Clock::now());
}

std::vector<NodeStatistics> PipelineObserver::nodes() const {
  std::vector<NodeStatistics> result;
  for (std::size_t i = 0; i < kNodes.size(); ++i) {
    const DurationStatistics busy = busy_[i].statistics();
    if (busy.count > 0) result.push_back({std::string(kNodes[i]), busy});
  }
  return result;
}

}  // namespace cylpose::graph
