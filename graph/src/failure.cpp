#include "failure.hpp"

#include <exception>

namespace cylpose::graph {

Error current_failure() {
  try {
    throw;
  } catch (const Error& error) {
    return error;
  } catch (const std::exception& error) {
    return {ErrorKind::kDevice, std::string("unexpected: ") + error.what()};
  }
}

std::string name_of(const InputFrame& frame) {
  return frame.name.empty() ? "frame " + std::to_string(frame.id) : frame.name;
}

std::vector<PoseEstimate> no_poses(const FrameTask& frame, std::size_t parts) {
  PoseEstimate none;
  none.reason = frame.failure->what();
  return std::vector<PoseEstimate>(parts, none);
}

}  // namespace cylpose::graph
