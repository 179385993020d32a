#include "opencl/watchdog.hpp"

#include <algorithm>
#include <utility>

namespace cylpose::opencl {

Watchdog::~Watchdog() {
  {
    const std::scoped_lock lock(mutex_);
    ending_ = true;
    changed_.notify_one();
  }
  if (thread_.joinable()) thread_.join();
}

Watchdog::Ticket Watchdog::add(Clock::time_point deadline, std::function<void()> late) {
  const std::scoped_lock lock(mutex_);
  entries_.push_back({++last_ticket_, deadline, std::move(late)});
  if (!thread_.joinable()) thread_ = std::thread(&Watchdog::watch, this);
  // Later deadlines need no notice: nearly all are dismissed long before they are due.
  if (deadline < wakes_) changed_.notify_one();
  return last_ticket_;
}

void Watchdog::dismiss(Ticket ticket) {
  std::function<void()> dismissed;  // destroyed without the lock: what it holds may be large
  const std::scoped_lock lock(mutex_);
  const auto found = std::ranges::find(entries_, ticket, &Entry::ticket);
  if (found == entries_.end()) return;
  dismissed = std::move(found->late);
  *found = std::move(entries_.back());
  entries_.pop_back();
}

void Watchdog::watch() {
  std::unique_lock lock(mutex_);
  while (!ending_) {
    const auto first = std::ranges::min_element(entries_, {}, &Entry::deadline);
    if (first != entries_.end() && first->deadline <= Clock::now()) {
      const std::function<void()> late = std::move(first->late);
      *first = std::move(entries_.back());
      entries_.pop_back();
      lock.unlock();
      late();
      lock.lock();
      continue;
    }
    wakes_ = first == entries_.end() ? Clock::time_point::max() : first->deadline;
    if (first == entries_.end()) {
      changed_.wait(lock);
    } else {
      changed_.wait_until(lock, wakes_);
    }
  }
}

}  // namespace cylpose::opencl
