// Deadlines for what no thread waits for.
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

namespace cylpose::opencl {

/// Has one thread, from the first deadline on, which sleeps until one is due.
class Watchdog {
 public:
  using Clock = std::chrono::steady_clock;
  using Ticket = std::uint64_t;

  Watchdog() = default;
  ~Watchdog();
  Watchdog(const Watchdog&) = delete;
  Watchdog& operator=(const Watchdog&) = delete;

  /// Calls `late` at `deadline`, from the watchdog's thread, which must not be held up for long.
  [[nodiscard]] Ticket add(Clock::time_point deadline, std::function<void()> late);

  /// Forgets a deadline. `late` may be running or have run all the same: its owner must tell.
  void dismiss(Ticket ticket);

 private:
  struct Entry {
    Ticket ticket;
    Clock::time_point deadline;
    std::function<void()> late;
  };

  void watch();

  std::mutex mutex_;
  std::condition_variable changed_;
  std::vector<Entry> entries_;  ///< a few: runs under way
  Ticket last_ticket_ = 0;
  Clock::time_point wakes_ = Clock::time_point::max();
  bool ending_ = false;
  std::thread thread_;
};

}  // namespace cylpose::opencl
