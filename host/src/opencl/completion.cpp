#include "opencl/completion.hpp"

#include <utility>

namespace cylpose::opencl {

void Completion::watch(cl_event event, std::string_view device) {
  status_.reset();
  start_ = std::chrono::steady_clock::now();
  check(clSetEventCallback(event, CL_COMPLETE, on_end, this), "clSetEventCallback", device);
}

std::optional<cl_int> Completion::wait(std::chrono::milliseconds timeout) {
  std::unique_lock lock(mutex_);
  ended_.wait_until(lock, start_ + timeout, [this] { return status_.has_value(); });
  return status_;
}

void Completion::when_ended(std::function<void()> then) {
  {
    const std::scoped_lock lock(mutex_);
    if (!status_) {
      then_ = std::move(then);
      return;
    }
  }
  then();
}

void CL_CALLBACK Completion::on_end(cl_event /*event*/, cl_int status, void* self) {
  auto& completion = *static_cast<Completion*>(self);
  std::function<void()> then;
  {
    // Notified under the lock: once it is free, the waiting thread may destroy the completion.
    const std::scoped_lock lock(completion.mutex_);
    completion.status_ = status;
    completion.end_ = std::chrono::steady_clock::now();
    then = std::exchange(completion.then_, nullptr);
    completion.ended_.notify_one();
  }
  if (then) then();
}

}  // namespace cylpose::opencl
