#include "intake.hpp"

#include <utility>

namespace cylpose::graph {

bool Intake::put(const FramePtr& frame, bool wait) {
  FramePtr stale;  // destroyed without the lock: its pixels may be large
  std::unique_lock lock(mutex_);
  if (policy_ == Policy::kAll) {
    const auto room = [this] { return closed_ || inside() < lag_ + kSpare; };
    if (wait) changed_.wait(lock, room);
    if (!room()) return false;
  }
  if (closed_) return false;
  if (policy_ == Policy::kLatest && !waiting_.empty()) {
    stale = std::move(waiting_.front());
    waiting_.pop_front();
    ++counts_.dropped;
  }
  frame->entered = Clock::now();
  waiting_.push_back(frame);
  ++counts_.accepted;
  return true;
}

FramePtr Intake::next() {
  const std::scoped_lock lock(mutex_);
  // A live frame that starts while the sink is behind would only be older when the sink gets it.
  const std::uint64_t done = policy_ == Policy::kAll ? counts_.solved : counts_.delivered;
  if (waiting_.empty() || counts_.started - done >= lag_) return nullptr;
  FramePtr frame = std::move(waiting_.front());
  waiting_.pop_front();
  frame->sequence = counts_.started++;
  return frame;
}

void Intake::solved() {
  const std::scoped_lock lock(mutex_);
  ++counts_.solved;
}

void Intake::left(bool delivered) {
  const std::scoped_lock lock(mutex_);
  ++(delivered ? counts_.delivered : counts_.dropped);
  changed_.notify_all();
}

void Intake::close() {
  std::deque<FramePtr> dropped;
  const std::scoped_lock lock(mutex_);
  closed_ = true;
  counts_.dropped += waiting_.size();
  dropped.swap(waiting_);
  changed_.notify_all();
}

bool Intake::closed() const {
  const std::scoped_lock lock(mutex_);
  return closed_;
}

void Intake::wait_until_empty() {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [this] { return inside() == 0; });
}

Intake::Counts Intake::counts() const {
  const std::scoped_lock lock(mutex_);
  return counts_;
}

}  // namespace cylpose::graph
