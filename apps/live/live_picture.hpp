// The overlay of the latest frame as JPEG, made only for those who ask, and not more often than bounded.
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <mutex>
#include <string>

#include "live_state.hpp"

namespace cylpose::apps {

class LivePicture {
 public:
  struct Jpeg {
    std::int64_t frame = 0;
    std::string bytes;
  };

  explicit LivePicture(const LiveState& state) : state_(state) {}

  /// Null while there is no frame with an image. Any thread, all of which share a picture: a new one is made at most
  /// every kLeastPause, and pauses are so long that making pictures takes no more than a tenth of a core. At the end
  /// of the run the last frame is always shown.
  [[nodiscard]] std::shared_ptr<const Jpeg> latest();

  [[nodiscard]] std::uint64_t made() const { return made_; }

  static constexpr int kMostWidth = 1280;  ///< pixels; wider ones are scaled down
  static constexpr std::chrono::milliseconds kLeastPause{100};

 private:
  using Clock = std::chrono::steady_clock;

  [[nodiscard]] std::shared_ptr<const Jpeg> drawn(const graph::FrameTask& frame) const;

  const LiveState& state_;
  std::mutex mutex_;
  std::shared_ptr<const Jpeg> jpeg_;
  Clock::time_point next_;
  std::atomic<std::uint64_t> made_ = 0;
};

}  // namespace cylpose::apps
