// A network as slow as wanted: a TCP proxy on loopback that limits the rate, delays, and stands still.
#pragma once

#include <atomic>
#include <chrono>
#include <string>
#include <thread>

namespace cylpose::testing {

/// Set before bytes flow or at any time; for each direction of each connection by itself.
struct LinkSettings {
  std::atomic<double> bytes_per_ms = 1e9;
  std::atomic<double> delay_ms = 0;  ///< one way
  std::atomic<bool> stalled = false;
};

class ThrottledLink {
 public:
  /// Takes connections to 127.0.0.1:`from` and makes them to 127.0.0.1:`to`. Throws std::runtime_error.
  ThrottledLink(int from, int to);
  ~ThrottledLink();
  ThrottledLink(const ThrottledLink&) = delete;
  ThrottledLink& operator=(const ThrottledLink&) = delete;

  [[nodiscard]] LinkSettings& settings() { return settings_; }

 private:
  void accept_all(const std::stop_token& stop);

  int to_;
  int listener_;
  LinkSettings settings_;
  std::jthread thread_;
};

}  // namespace cylpose::testing
