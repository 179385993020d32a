// Waiting for an event, but not for ever.
#pragma once

#include <chrono>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <optional>

#include "opencl/api.hpp"

namespace cylpose::opencl {

/// OpenCL's own waits have no limit: a device that hangs would take the caller with it. Here the driver calls back.
/// Must outlive the callback: where wait() returned nothing, for ever.
class Completion {
 public:
  /// Asks to be called back when `event` ends. One event at a time.
  void watch(cl_event event, std::string_view device);

  /// Status of the event (CL_COMPLETE, or an error), nothing if it did not end within `timeout` of watch().
  [[nodiscard]] std::optional<cl_int> wait(std::chrono::milliseconds timeout);

  /// Calls `then` when the event has ended: at once, or from the driver's callback. One call at a time.
  void when_ended(std::function<void()> then);

  /// When watch() was called.
  [[nodiscard]] std::chrono::steady_clock::time_point start() const { return start_; }

  /// From watch() to the end of the event that was waited for.
  [[nodiscard]] double milliseconds() const { return std::chrono::duration<double, std::milli>(end_ - start_).count(); }

 private:
  static void CL_CALLBACK on_end(cl_event event, cl_int status, void* self);

  std::mutex mutex_;
  std::condition_variable ended_;
  std::optional<cl_int> status_;
  std::function<void()> then_;
  std::chrono::steady_clock::time_point start_;
  std::chrono::steady_clock::time_point end_;
};

}  // namespace cylpose::opencl
