// Memory for frames that is used again and again.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <opencv2/core/mat.hpp>

namespace cylpose {

/// Pixels of frames come from here and go back when the last cv::Mat on them ends, on whatever thread, also after the
/// pool itself has ended. A fresh frame costs page faults, 0.3 ms for 1280x720; a used one nothing. Keeps as many as
/// were ever in use at once, all of one size: another size empties the pool. Aligned to pages, so that devices can use
/// them where they lie. Any thread.
class FramePool {
 public:
  FramePool();

  /// Uninitialised pixels. `type`: CV_8UC3 or CV_8UC1, or whatever OpenCV has.
  [[nodiscard]] cv::Mat take(int rows, int columns, int type) const;

  /// What `fill` reads or decodes into the empty Mat that it is given, in memory from here.
  [[nodiscard]] cv::Mat filled(const std::function<void(cv::Mat& frame)>& fill) const;

  /// Bytes of the frames that wait to be used again.
  [[nodiscard]] std::size_t idle_bytes() const;

 private:
  class Allocator;
  std::shared_ptr<Allocator> allocator_;
};

}  // namespace cylpose
