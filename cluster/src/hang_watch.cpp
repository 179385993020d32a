#include <condition_variable>
#include <cylpose/cluster/hang_watch.hpp>
#include <cylpose/error.hpp>
#include <mutex>
#include <thread>
#include <utility>

namespace cylpose::cluster {
namespace {

using Clock = std::chrono::steady_clock;

class HangWatch final : public Backend {
 public:
  HangWatch(std::unique_ptr<Backend> backend, std::chrono::milliseconds hang_after,
            std::function<void(const std::string&)> on_hang)
      : backend_(std::move(backend)),
        hang_after_(hang_after),
        on_hang_(std::move(on_hang)),
        thread_([this](const std::stop_token& stop) { watch(stop); }) {}

  [[nodiscard]] std::string_view name() const override { return backend_->name(); }

  [[nodiscard]] EdgeField detect(const ImageView& image, const Roi& search, std::span<const PartModel> parts,
                                 const DetectOptions& options) override {
    constexpr std::chrono::minutes kBuildingKernels{2};
    const auto extra = std::exchange(first_, false) ? kBuildingKernels : kBuildingKernels.zero();
    const Busy busy(*this, Clock::now() + hang_after_ + extra);
    return backend_->detect(image, search, parts, options);
  }

 private:
  class Busy {
   public:
    Busy(HangWatch& watch, Clock::time_point due) : watch_(watch) { watch_.set_due(due); }
    ~Busy() { watch_.set_due(Clock::time_point::max()); }
    Busy(const Busy&) = delete;
    Busy& operator=(const Busy&) = delete;

   private:
    HangWatch& watch_;
  };

  void set_due(Clock::time_point due) {
    {
      const std::scoped_lock lock(mutex_);
      due_ = due;
    }
    changed_.notify_one();
  }

  void watch(const std::stop_token& stop) {
    std::unique_lock lock(mutex_);
    while (!stop.stop_requested()) {
      const auto due = due_;
      const auto is_new = [&] { return due_ != due; };
      if (due == Clock::time_point::max()) {
        changed_.wait(lock, stop, is_new);
        continue;
      }
      if (changed_.wait_until(lock, stop, due, is_new) || stop.stop_requested()) continue;
      due_ = Clock::time_point::max();
      lock.unlock();
      on_hang_("the device hangs: a detection has taken more than " + std::to_string(hang_after_.count()) + " ms");
      lock.lock();
    }
  }

  std::unique_ptr<Backend> backend_;
  std::chrono::milliseconds hang_after_;
  std::function<void(const std::string&)> on_hang_;
  bool first_ = true;
  std::mutex mutex_;
  std::condition_variable_any changed_;
  Clock::time_point due_ = Clock::time_point::max();  ///< of the detection that is going on
  std::jthread thread_;                               ///< ends first
};

}  // namespace

std::unique_ptr<Backend> watched(std::unique_ptr<Backend> backend, std::chrono::milliseconds hang_after,
                                 std::function<void(const std::string&)> on_hang) {
  if (hang_after.count() <= 0) {
    throw Error(ErrorKind::kInput,
                "a device is said to hang after " + std::to_string(hang_after.count()) + " ms; must be above 0");
  }
  return std::make_unique<HangWatch>(std::move(backend), hang_after, std::move(on_hang));
}

}  // namespace cylpose::cluster
