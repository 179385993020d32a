// Ctrl-C ends a run after the frame at hand, so that all files are closed properly.
#pragma once

namespace cylpose::apps {

/// While it lives, SIGINT and SIGTERM only ask to end; a second one ends at once. SIGPIPE is ignored, so that writing
/// to a closed pipe fails with a message instead of killing the run.
class InterruptGuard {
 public:
  InterruptGuard();
  ~InterruptGuard();
  InterruptGuard(const InterruptGuard&) = delete;
  InterruptGuard& operator=(const InterruptGuard&) = delete;

  [[nodiscard]] static bool requested();
};

}  // namespace cylpose::apps
