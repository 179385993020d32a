// What was thrown, as a value.
#pragma once

#include <cylpose/graph/frame_task.hpp>

namespace cylpose::graph {

/// The exception being handled, for FrameTask::failure. What is no Error counts as a failure of the machine.
[[nodiscard]] Error current_failure();

/// How messages call the frame: its name, or "frame 12".
[[nodiscard]] std::string name_of(const InputFrame& frame);

/// Estimates for a failed frame: `none` with the failure as the reason.
[[nodiscard]] std::vector<PoseEstimate> no_poses(const FrameTask& frame, std::size_t parts);

}  // namespace cylpose::graph
