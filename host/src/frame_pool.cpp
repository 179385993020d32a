#include <cylpose/frame_pool.hpp>
#include <mutex>
#include <new>
#include <opencv2/core.hpp>
#include <utility>
#include <vector>

namespace cylpose {

// As OpenCV's own allocator, except where the memory comes from. Every frame in use keeps it alive.
class FramePool::Allocator final : public cv::MatAllocator, public std::enable_shared_from_this<Allocator> {
 public:
  Allocator() = default;
  ~Allocator() override {
    for (void* block : idle_) release(block);
  }
  Allocator(const Allocator&) = delete;
  Allocator& operator=(const Allocator&) = delete;

  cv::UMatData* allocate(int dims, const int* sizes, int type, void* data, std::size_t* step, cv::AccessFlag /*flags*/,
                         cv::UMatUsageFlags /*usage*/) const override {
    std::size_t total = CV_ELEM_SIZE(type);
    for (int i = dims - 1; i >= 0; --i) {
      if (step != nullptr) step[i] = total;
      total *= static_cast<std::size_t>(sizes[i]);
    }
    auto frame = std::make_unique<cv::UMatData>(this);
    auto keeper = std::make_unique<std::shared_ptr<const Allocator>>(shared_from_this());
    frame->data = frame->origdata = static_cast<uchar*>(data != nullptr ? data : block_of(total));
    frame->size = total;
    if (data != nullptr) frame->flags |= cv::UMatData::USER_ALLOCATED;
    frame->userdata = keeper.release();
    return frame.release();
  }

  bool allocate(cv::UMatData* frame, cv::AccessFlag /*flags*/, cv::UMatUsageFlags /*usage*/) const override {
    return frame != nullptr;
  }

  void deallocate(cv::UMatData* frame) const override {
    if (frame == nullptr) return;
    const std::unique_ptr<cv::UMatData> owned(frame);
    // Last: this may be the pool's end.
    const std::unique_ptr<std::shared_ptr<const Allocator>> keeper(
        static_cast<std::shared_ptr<const Allocator>*>(frame->userdata));
    if ((frame->flags & cv::UMatData::USER_ALLOCATED) == 0) give_back(frame->origdata, frame->size);
  }

  [[nodiscard]] std::size_t idle_bytes() const {
    const std::scoped_lock lock(mutex_);
    return idle_.size() * block_bytes_;
  }

 private:
  static constexpr std::align_val_t kPage{4096};

  static void release(void* block) { ::operator delete(block, kPage); }

  void* block_of(std::size_t bytes) const {
    std::vector<void*> outdated;
    void* block = nullptr;
    {
      const std::scoped_lock lock(mutex_);
      if (bytes != block_bytes_) outdated = std::exchange(idle_, {});
      block_bytes_ = bytes;
      if (!idle_.empty()) {
        block = idle_.back();
        idle_.pop_back();
      }
    }
    for (void* old : outdated) release(old);
    return block != nullptr ? block : ::operator new(bytes, kPage);
  }

  void give_back(void* block, std::size_t bytes) const {
    {
      const std::scoped_lock lock(mutex_);
      if (bytes == block_bytes_) {
        idle_.push_back(block);
        return;
      }
    }
    release(block);
  }

  mutable std::mutex mutex_;
  mutable std::vector<void*> idle_;
  mutable std::size_t block_bytes_ = 0;
};

FramePool::FramePool() : allocator_(std::make_shared<Allocator>()) {}

cv::Mat FramePool::take(int rows, int columns, int type) const {
  return filled([&](cv::Mat& frame) { frame.create(rows, columns, type); });
}

cv::Mat FramePool::filled(const std::function<void(cv::Mat& frame)>& fill) const {
  cv::Mat frame;
  frame.allocator = allocator_.get();
  fill(frame);
  // The memory knows its way back; new memory for this Mat may be wanted when the pool is gone.
  frame.allocator = nullptr;
  return frame;
}

std::size_t FramePool::idle_bytes() const {
  return allocator_->idle_bytes();
}

}  // namespace cylpose
