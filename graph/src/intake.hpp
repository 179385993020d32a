// The entrance of the pipeline: which frames wait, which may start, which are dropped, and how many are inside.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <cylpose/graph/pipeline.hpp>
#include <deque>
#include <mutex>

namespace cylpose::graph {

/// A limiter in both senses of Policy. oneTBB's limiter_node bounds frames too, but what waits before it cannot be
/// replaced by what is newer. Any thread.
class Intake {
 public:
  struct Counts {
    std::uint64_t accepted = 0;
    std::uint64_t dropped = 0;
    std::uint64_t started = 0;
    std::uint64_t solved = 0;
    std::uint64_t delivered = 0;
  };

  Intake(Policy policy, int lag) : policy_(policy), lag_(static_cast<std::uint64_t>(lag)) {}

  /// Takes a frame in. False: no room (only without `wait`), or closed.
  bool put(const FramePtr& frame, bool wait);

  /// The next frame that may start, numbered; null while there is none.
  [[nodiscard]] FramePtr next();

  void solved();              ///< a frame's result is known: another one may start
  void left(bool delivered);  ///< the frame is with the user, or nobody wants it any more

  /// Drops what waits; nothing gets in any more.
  void close();
  [[nodiscard]] bool closed() const;

  /// Waits until nothing waits or is under way.
  void wait_until_empty();

  [[nodiscard]] Counts counts() const;

  /// Frames inside at most.
  [[nodiscard]] static std::uint64_t capacity(int lag) { return static_cast<std::uint64_t>(lag) + kSpare; }

 private:
  // One being put, one with the sink: neither is at work, and the cores should not wait for them.
  static constexpr std::uint64_t kSpare = 2;

  [[nodiscard]] std::uint64_t inside() const { return counts_.accepted - counts_.dropped - counts_.delivered; }

  const Policy policy_;
  const std::uint64_t lag_;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<FramePtr> waiting_;
  Counts counts_;
  bool closed_ = false;
};

}  // namespace cylpose::graph
