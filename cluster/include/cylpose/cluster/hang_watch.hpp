// A device that hangs holds its thread for ever; somebody else has to notice.
#pragma once

#include <chrono>
#include <cylpose/backend.hpp>
#include <functional>
#include <memory>
#include <string>

namespace cylpose::cluster {

/// `backend`, and a thread that calls `on_hang` when a detection takes longer than `hang_after` (above 0); the very
/// first one, which builds kernels, may take two minutes more. The hanging thread never comes back: end the process and
/// have it started again. One detection at a time. Throws Error(kInput).
[[nodiscard]] std::unique_ptr<Backend> watched(std::unique_ptr<Backend> backend, std::chrono::milliseconds hang_after,
                                               std::function<void(const std::string& what)> on_hang);

}  // namespace cylpose::cluster
