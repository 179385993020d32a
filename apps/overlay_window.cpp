#include "overlay_window.hpp"

#include <fmt/format.h>

#include <cstdlib>
#include <cylpose/error.hpp>
#include <opencv2/highgui.hpp>
#include <utility>

namespace cylpose::apps {

OverlayWindow::OverlayWindow(std::string title) : title_(std::move(title)) {
  const auto refuse = [](const std::string& why) {
    throw Error(ErrorKind::kOutput, fmt::format("--show: no window can be opened: {}; run it on a desktop, or write "
                                                "pictures with --overlay",
                                                why));
  };
  // Some of OpenCV's window libraries end the process where there is no screen.
  if (std::getenv("DISPLAY") == nullptr && std::getenv("WAYLAND_DISPLAY") == nullptr) {
    refuse("neither DISPLAY nor WAYLAND_DISPLAY is set");
  }
  try {
    cv::namedWindow(title_, cv::WINDOW_NORMAL | cv::WINDOW_KEEPRATIO);
  } catch (const cv::Exception& error) {
    refuse(error.err);
  }
}

OverlayWindow::~OverlayWindow() {
  try {
    cv::destroyWindow(title_);
  } catch (const cv::Exception&) {
    // The user closed it.
  }
}

void OverlayWindow::offer(const cv::Mat& picture) {
  const std::scoped_lock lock(mutex_);
  next_ = picture;
}

bool OverlayWindow::update() {
  constexpr int kEscape = 27;
  cv::Mat picture;
  {
    const std::scoped_lock lock(mutex_);
    picture = std::exchange(next_, {});
  }
  if (shown_ && cv::getWindowProperty(title_, cv::WND_PROP_VISIBLE) < 1) return false;
  if (!picture.empty()) {
    if (!shown_) cv::resizeWindow(title_, picture.cols, picture.rows);
    cv::imshow(title_, picture);
    shown_ = true;
  }
  const int key = cv::pollKey();
  return key != kEscape && key != 'q';
}

}  // namespace cylpose::apps
