#include "stream.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <cylpose/cylinder.hpp>
#include <cylpose/estimator.hpp>
#include <cylpose/pose_solver.hpp>
#include <cylpose/search_region.hpp>
#include <deque>
#include <mutex>
#include <opencv2/imgproc.hpp>
#include <random>
#include <thread>

namespace cylpose::testing {
namespace {

using graph::InputFrame;

constexpr int kJump = 9;  // from here on elsewhere
constexpr int kHidden = 14;
constexpr int kFailed = 5;
constexpr int kWrongSize = 17;

cv::Mat picture(int index) {
  constexpr int kSamples = 3;  // per pixel and direction
  const CameraModel camera = stream_camera();
  const double step = index < kJump ? index : index - 2.0 * kJump;
  const CylinderPose pose{{0.004 * step, 0.002 * step, 1.2}, Eigen::Vector3d(0.1 + 0.01 * step, -1, 0.2).normalized()};
  cv::Mat large(camera.height * kSamples, camera.width * kSamples, CV_8UC3, cv::Scalar(120, 120, 120));
  for (int y = 0; y < large.rows && index != kHidden; ++y) {
    for (int x = 0; x < large.cols; ++x) {
      const double u = ((x + 0.5) / kSamples - 0.5 - camera.cx) / camera.fx;
      const double v = ((y + 0.5) / kSamples - 0.5 - camera.cy) / camera.fy;
      if (intersect_ray(pose, 0.05, 0.3, {u, v, 1})) large.at<cv::Vec3b>(y, x) = {30, 25, 200};
    }
  }
  cv::Mat small;
  cv::resize(large, small, {camera.width, camera.height}, 0, 0, cv::INTER_AREA);
  return small;
}

const std::vector<cv::Mat>& pictures() {
  static const std::vector<cv::Mat> all = [] {
    std::vector<cv::Mat> rendered;
    for (int i = 0; i < kStreamFrames; ++i) rendered.push_back(picture(i));
    return rendered;
  }();
  return all;
}

class SlowDevice final : public Backend {
 public:
  SlowDevice(unsigned seed, int most_microseconds) : random_(seed), wait_us_(0, most_microseconds) {
    for (int i = 0; i < 3; ++i) threads_.emplace_back([this] { work(); });
  }
  ~SlowDevice() override {
    {
      const std::scoped_lock lock(mutex_);
      ending_ = true;
      changed_.notify_all();
    }
    for (std::thread& thread : threads_) thread.join();
  }
  SlowDevice(const SlowDevice&) = delete;
  SlowDevice& operator=(const SlowDevice&) = delete;

  [[nodiscard]] std::string_view name() const override { return "slow"; }
  [[nodiscard]] EdgeField detect(const ImageView& image, const Roi& search, std::span<const PartModel> parts,
                                 const DetectOptions& options) override {
    return serial_->detect(image, search, parts, options);
  }
  void detect_async(const DetectRequest& request, const OnDetected& done) override {
    const std::scoped_lock lock(mutex_);
    jobs_.push_back({request, done, std::chrono::microseconds(wait_us_(random_))});
    changed_.notify_one();
  }

 private:
  struct Job {
    DetectRequest request;
    OnDetected done;
    std::chrono::microseconds wait;
  };

  void work() {
    std::unique_lock lock(mutex_);
    for (;;) {
      changed_.wait(lock, [this] { return ending_ || !jobs_.empty(); });
      if (jobs_.empty()) return;
      const Job job = std::move(jobs_.front());
      jobs_.pop_front();
      lock.unlock();
      std::this_thread::sleep_for(job.wait);
      serial_->detect_async(job.request, job.done);
      lock.lock();
    }
  }

  std::unique_ptr<Backend> serial_ = make_backend("serial");
  std::mt19937 random_;
  std::uniform_int_distribution<int> wait_us_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<Job> jobs_;
  bool ending_ = false;
  std::vector<std::thread> threads_;
};

// The definition, without rings and snapshots: after each frame everything known then is kept.
class NaiveStream {
 public:
  NaiveStream(std::size_t lag, const std::optional<FilterOptions>& options)
      : solver_(stream_camera(), stream_parts()), lag_(lag), region_(stream_camera()) {
    if (options) filter_.emplace(stream_camera(), stream_parts(), *options);
  }

  FrameEstimate next(const InputFrame& frame) {
    FrameEstimate result;
    const bool usable = !frame.failure && frame.image.view.width == stream_camera().width;
    if (usable) {
      const Roi search = search_in(frame);
      result = estimate(frame, search);
      if (search != region_.whole() && result.parts[0].status == PoseStatus::kNone) {
        result = estimate(frame, region_.whole());
      }
      region_.update(stream_parts(), result.parts);
    } else {
      result.parts.resize(stream_parts().size());
      result.parts[0].reason = "unusable";
    }
    if (filter_) result.parts = filter_->update(frame.timestamp_s, result.parts);
    regions_.push_back(region_.next());
    filters_.push_back(filter_);
    return result;
  }

 private:
  [[nodiscard]] Roi search_in(const InputFrame& frame) const {
    if (regions_.size() < lag_)
      return filter_ ? PoseFilter(stream_camera(), stream_parts()).search_region(frame.timestamp_s) : region_.whole();
    const std::size_t old = regions_.size() - lag_;
    return filter_ ? filters_[old]->search_region(frame.timestamp_s) : regions_[old];
  }

  FrameEstimate estimate(const InputFrame& frame, const Roi& search) {
    const EdgeField field = serial_->detect(frame.image.view, search, stream_parts(), {});
    return {field.searched, solver_.solve(field), {}};
  }

  PoseSolver solver_;
  std::size_t lag_;
  SearchRegion region_;
  std::unique_ptr<Backend> serial_ = make_backend("serial");
  std::optional<PoseFilter> filter_;
  std::vector<Roi> regions_;
  std::vector<std::optional<PoseFilter>> filters_;
};

}  // namespace

CameraModel stream_camera() {
  CameraModel camera;
  camera.width = 200;
  camera.height = 150;
  camera.fx = camera.fy = 260;
  camera.cx = 99.5;
  camera.cy = 74.5;
  return camera;
}

std::vector<PartModel> stream_parts() {
  return {{"can", 0.05, 0.3, 340, 20, 0.4, 0.2}};
}

InputFrame good_frame(int index) {
  return {index, index / 30.0, "", graph::shared(pictures()[static_cast<std::size_t>(index % kStreamFrames)]), {}};
}

InputFrame stream_frame(int index) {
  InputFrame frame = good_frame(index);
  if (index % kStreamFrames == kFailed) {
    frame.image = {};
    frame.failure = Error(ErrorKind::kInput, "unusable");
  }
  if (index % kStreamFrames == kWrongSize) frame.image = graph::shared(cv::Mat(30, 40, CV_8UC3, cv::Scalar(0, 0, 0)));
  return frame;
}

std::vector<FrameEstimate> one_at_a_time(const std::vector<InputFrame>& frames, std::size_t lag,
                                         const std::optional<FilterOptions>& filter) {
  NaiveStream stream(lag, filter);
  std::vector<FrameEstimate> estimates;
  for (const InputFrame& frame : frames) estimates.push_back(stream.next(frame));
  return estimates;
}

void expect_same(const FrameEstimate& actual, const FrameEstimate& expected, const std::string& what) {
  SCOPED_TRACE(what);
  EXPECT_EQ(actual.searched, expected.searched);
  ASSERT_EQ(actual.parts.size(), expected.parts.size());
  for (std::size_t i = 0; i < actual.parts.size(); ++i) {
    const PoseEstimate& a = actual.parts[i];
    const PoseEstimate& b = expected.parts[i];
    ASSERT_EQ(a.status, b.status);
    if (a.status == PoseStatus::kNone) continue;
    EXPECT_EQ(a.pose.center_in_cam, b.pose.center_in_cam);
    EXPECT_EQ(a.pose.axis_in_cam, b.pose.axis_in_cam);
    EXPECT_EQ(a.covariance, b.covariance);
    EXPECT_EQ(a.rms_px, b.rms_px);
  }
}

std::unique_ptr<Backend> make_slow_device(unsigned seed, int most_microseconds) {
  return std::make_unique<SlowDevice>(seed, most_microseconds);
}

}  // namespace cylpose::testing
