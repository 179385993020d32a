// From the threads of a pipeline to those of Python.
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <cylpose/graph/frame_task.hpp>
#include <deque>
#include <exception>
#include <mutex>
#include <optional>

namespace cylpose::python {

/// Finished frames in order. Nothing in it knows of Python: the pipeline's threads never need the GIL.
class ResultQueue {
 public:
  /// `capacity`: how many frames wait before `put` does.
  explicit ResultQueue(std::size_t capacity) : capacity_(capacity) {}

  /// Waits for room. After close the frame is dropped.
  void put(graph::FramePtr frame);

  /// Nothing comes any more; `failure`, where there is one, is thrown behind the last frame, once.
  void end(std::exception_ptr failure = {});

  /// Ends, drops what waits and lets go whoever waits.
  void close();

  /// The next frame; null at the end, none when nothing has come within the time. Throws the failure.
  [[nodiscard]] std::optional<graph::FramePtr> take(std::chrono::milliseconds patience);

 private:
  const std::size_t capacity_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<graph::FramePtr> frames_;
  std::exception_ptr failure_;
  bool ended_ = false;
  bool closed_ = false;
};

}  // namespace cylpose::python
