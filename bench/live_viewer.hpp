// Somebody who looks at the live page, as far as the server can tell.
#pragma once

#include <atomic>
#include <thread>

namespace cylpose::bench {

/// Reads the events of a page on this machine and asks for a picture after each one, as the page's script does.
class LiveViewer {
 public:
  /// Waits for the first event.
  explicit LiveViewer(int port);
  ~LiveViewer();
  LiveViewer(const LiveViewer&) = delete;
  LiveViewer& operator=(const LiveViewer&) = delete;

 private:
  std::atomic<bool> looking_ = false;
  std::atomic<bool> gone_ = false;
  std::thread thread_;
};

}  // namespace cylpose::bench
