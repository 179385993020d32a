// The overlay on the screen.
#pragma once

#include <mutex>
#include <opencv2/core/mat.hpp>
#include <string>

namespace cylpose::apps {

/// A window that shows the newest picture. Made and updated on one thread, as window systems want it.
class OverlayWindow {
 public:
  /// Throws Error(kOutput) where there is no screen.
  explicit OverlayWindow(std::string title);
  ~OverlayWindow();
  OverlayWindow(const OverlayWindow&) = delete;
  OverlayWindow& operator=(const OverlayWindow&) = delete;

  /// The picture to show next, in place of one that has not been shown yet. Any thread.
  void offer(const cv::Mat& picture);

  /// Shows what was offered and looks at the keys. False once the window was closed, or q or Escape pressed.
  [[nodiscard]] bool update();

 private:
  std::string title_;
  std::mutex mutex_;
  cv::Mat next_;
  bool shown_ = false;
};

}  // namespace cylpose::apps
