// Whether sharing frames pays, judged by what frames took and not by what was predicted.
#pragma once

#include <algorithm>

namespace cylpose::cluster {

class ShareJudge {
 public:
  /// A frame is over.
  void alone(double ms_per_pixel) {
    take(alone_, ms_per_pixel);
    if (wait_ > 0) --wait_;
  }
  void shared(double ms_per_pixel) {
    take(shared_, ms_per_pixel);
    constexpr int kFirstWait = 32;  // frames, so that a vain attempt costs no more than some per cent
    constexpr int kLongestWait = 2048;
    if (shared_ < alone_ || alone_ == 0) {
      pause_ = kFirstWait;
    } else {
      wait_ = pause_;
      pause_ = std::min(2 * pause_, kLongestWait);
      shared_ = 0;  // the next attempt counts by itself
    }
  }
  /// Sharing was quicker, or it is time to see.
  [[nodiscard]] bool allows_sharing() const { return wait_ == 0; }

 private:
  static void take(double& average, double value) {
    constexpr double kWeight = 0.2;  // of the newest
    average = average == 0 ? value : average + kWeight * (value - average);
  }

  double alone_ = 0;
  double shared_ = 0;
  int wait_ = 0;
  int pause_ = 32;
};

}  // namespace cylpose::cluster
