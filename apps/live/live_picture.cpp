#include "live_picture.hpp"

#include <algorithm>
#include <ctime>
#include <cylpose/error.hpp>
#include <cylpose/overlay.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <utility>
#include <vector>

namespace cylpose::apps {
namespace {

/// Work of this thread so far, whatever others do on its core.
std::chrono::nanoseconds worked() {
  timespec time{};
  ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return std::chrono::seconds(time.tv_sec) + std::chrono::nanoseconds(time.tv_nsec);
}

}  // namespace

std::shared_ptr<const LivePicture::Jpeg> LivePicture::latest() {
  const std::scoped_lock lock(mutex_);
  const graph::FramePtr frame = state_.frame_with_image();
  if (!frame || (jpeg_ && jpeg_->frame == frame->id)) return jpeg_;
  if (Clock::now() < next_ && !state_.has_ended()) return jpeg_;
  constexpr int kPausePerWork = 9;
  const std::chrono::nanoseconds before = worked();
  jpeg_ = drawn(*frame);
  next_ = Clock::now() + std::max<Clock::duration>(kLeastPause, kPausePerWork * (worked() - before));
  ++made_;
  return jpeg_;
}

std::shared_ptr<const LivePicture::Jpeg> LivePicture::drawn(const graph::FrameTask& frame) const {
  cv::Mat picture = overlay(mat_of(frame.image.view), state_.camera(), state_.parts(), frame.estimate);
  if (picture.cols > kMostWidth) {
    const double scale = static_cast<double>(kMostWidth) / picture.cols;
    cv::resize(picture, picture, {}, scale, scale, cv::INTER_AREA);
  }
  constexpr int kQuality = 80;
  std::vector<std::uint8_t> bytes;
  if (!cv::imencode(".jpg", picture, bytes, {cv::IMWRITE_JPEG_QUALITY, kQuality})) {
    throw Error(ErrorKind::kOutput, "the live page's picture cannot be encoded");
  }
  return std::make_shared<const Jpeg>(Jpeg{frame.id, std::string(bytes.begin(), bytes.end())});
}

}  // namespace cylpose::apps
