// One part's filter and what the tests do with it.
#pragma once

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cylpose/pose_filter.hpp>

#include "ideal_edges.hpp"
#include "moving_cylinder.hpp"

namespace cylpose::testing {

inline constexpr double kFrame = 1.0 / 30;
inline const PoseEstimate kNotSeen = [] {
  PoseEstimate none;
  none.reason = "no pixel of the part's colour";
  return none;
}();

// What the simulated measurements are: independent, of the covariance that they state.
inline FilterOptions matched(double velocity_drift, double rate_drift) {
  FilterOptions options;
  options.velocity_drift_m_s = velocity_drift;
  options.rate_drift_rad_s = rate_drift;
  options.covariance_scale = 1;
  return options;
}

class PoseFilterTest : public ::testing::Test {
 protected:
  /// One part's next frame.
  PoseEstimate update(PoseFilter& filter, double time, const PoseEstimate& measured) {
    return filter.update(time, std::array{measured}).front();
  }

  /// Follows a motion for `seconds` from the time `now` on; the last estimate.
  PoseEstimate follow(PoseFilter& filter, MovingCylinder& cylinder, Measuring& measure, double seconds) {
    PoseEstimate last;
    for (const double end = now + seconds - kFrame / 2; now < end;) {
      now += kFrame;
      last = update(filter, now, measure(cylinder.advance(kFrame)));
    }
    return last;
  }

  PoseFilter made(const FilterOptions& options = {}) { return PoseFilter(camera, {part}, options); }

  CameraModel camera = test_camera();
  PartModel part = test_part();
  Roi whole{0, 0, camera.width, camera.height};
  double now = 0;
};

/// Poses far from the truth and, unless they are asked for again, from each other.
inline PoseEstimate wrong(Measuring& measure, int which) {
  const double k = which;
  return measure({{0.3 * std::cos(2.5 * k), 0.2 * std::sin(2.5 * k), 2 + 0.5 * std::sin(k)},
                  Eigen::Vector3d(std::cos(k), std::sin(2 * k), std::sin(k) - 0.4).normalized()});
}

}  // namespace cylpose::testing
