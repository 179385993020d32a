#include "result_queue.hpp"

#include <utility>

namespace cylpose::python {

void ResultQueue::put(graph::FramePtr frame) {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [this] { return closed_ || frames_.size() < capacity_; });
  if (closed_) return;
  frames_.push_back(std::move(frame));
  changed_.notify_all();
}

void ResultQueue::end(std::exception_ptr failure) {
  const std::scoped_lock lock(mutex_);
  ended_ = true;
  failure_ = std::move(failure);
  changed_.notify_all();
}

void ResultQueue::close() {
  std::deque<graph::FramePtr> dropped;
  const std::scoped_lock lock(mutex_);
  closed_ = true;
  ended_ = true;
  dropped.swap(frames_);
  changed_.notify_all();
}

std::optional<graph::FramePtr> ResultQueue::take(std::chrono::milliseconds patience) {
  std::unique_lock lock(mutex_);
  if (!changed_.wait_for(lock, patience, [this] { return ended_ || !frames_.empty(); })) return std::nullopt;
  if (frames_.empty()) {
    if (failure_ && !closed_) std::rethrow_exception(std::exchange(failure_, nullptr));
    return nullptr;
  }
  graph::FramePtr frame = std::move(frames_.front());
  frames_.pop_front();
  changed_.notify_all();
  return frame;
}

}  // namespace cylpose::python
