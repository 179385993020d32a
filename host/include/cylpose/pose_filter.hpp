// The poses of one stream of frames, filtered over time (docs/algorithm.md, "Filter").
#pragma once

#include <cylpose/camera.hpp>
#include <cylpose/image.hpp>
#include <cylpose/part.hpp>
#include <cylpose/pose.hpp>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace cylpose {

/// How parts move, how far measurements are believed, and how tracks begin and end. The defaults suit slow, smooth
/// motion: bodies that tumble or approach, robot arms. For what is held or carried by hand see `hand_held`.
struct FilterOptions {
  /// Standard deviation, per direction, by which the velocity of the centre changes within one second, m/s (white
  /// acceleration of this density squared, in m^2/s^3: over t seconds it is sqrt(t) times that). Smaller smooths more
  /// and predicts farther; too small, and real turns are rejected until `switch_frames` of them have been seen. > 0.
  double velocity_drift_m_s = 0.15;
  /// The same for the angular velocity of the axis, rad/s. A steady turn about another axis than one across the part
  /// (coning) counts as a change, too. > 0.
  double rate_drift_rad_s = 0.3;
  /// Standard deviations, per direction, of the velocity (m/s) and the angular velocity (rad/s) with which a part may
  /// come into view. Larger, and wrong measurements find it easier to agree with each other. > 0.
  double start_speed_m_s = 0.5;
  double start_rate_rad_s = 1;
  /// Factor on the covariance of every measurement. Before difficult backgrounds that covariance is up to five times
  /// too small, and errors of successive frames resemble each other, so that they average out more slowly than noise
  /// does. 1: as delivered. Smaller narrows the gate and trusts each frame more. > 0.
  double covariance_scale = 4;
  /// A measurement is rejected when its squared Mahalanobis distance from the prediction is above this. Of right ones
  /// 0.1 % are (chi-square, 5 degrees of freedom); 15.1 rejects 1 %. > 0.
  double gate_chi2 = 20.5;
  /// Measurements, each within the gate of what the ones before predict, that start a track or take up one that has
  /// coasted over this many frames. More delays the filter, fewer lets chance in. >= 1.
  int confirm_frames = 3;
  /// The same for measurements that contradict a track, which they then replace: a wrong pose persists no longer than
  /// this after the right ones return. >= confirm_frames.
  int switch_frames = 5;
  /// How long, in seconds, a track goes on without an accepted measurement; its part counts as lost afterwards. > 0.
  double max_coast_s = 1.5;
  /// A track does not go on, either, when the standard deviation of its centre (m) or its axis (degrees) is above these
  /// in the worst direction. > 0.
  double max_center_sigma_m = 0.5;
  double max_axis_sigma_deg = 20;

  /// For parts or cameras moved by hand: accelerations up to some 5 m/s^2 and 20 rad/s^2, changing
  /// every fifth of a second.
  [[nodiscard]] static FilterOptions hand_held();

  /// False, with the reason in `why`, for values out of range or not finite.
  bool is_valid(std::string* why) const;
};

/// Constant-velocity error-state Kalman filters, one per part, on the centre (3) and the axis direction (2, on the unit
/// sphere). One stream of frames in order of time; not thread-safe.
class PoseFilter {
 public:
  /// Throws Error(kInput) for an invalid camera, parts or options.
  PoseFilter(CameraModel camera, std::vector<PartModel> parts, FilterOptions options = {});
  ~PoseFilter();
  /// A copy goes on from the same state, by itself: for predictions from a moment that the original has left behind.
  PoseFilter(const PoseFilter& other);
  PoseFilter& operator=(const PoseFilter& other);
  PoseFilter(PoseFilter&&) noexcept;
  PoseFilter& operator=(PoseFilter&&) noexcept;

  /// Takes the measured estimates of one frame, one per part, each kOk or kNone, and returns the filtered ones:
  ///  - kOk: the measurement was accepted; filtered pose and covariance, all else as measured. Before a track is
  ///    confirmed: the measurement as it is.
  ///  - kPredicted: not measured, or the measurement rejected (`reason` says which); pose and covariance predicted,
  ///    sides those of the predicted pose (their normals zero where none are seen), rms_px, support and seen zero.
  ///  - kNone: not measured, no track; the measurement's reason.
  /// In all of them the sign of the axis is the one nearest to the part's last axis; only the first is as measured.
  /// Time stamps in seconds, spaced as you like, must increase. Throws Error(kInput) for one that is not finite or not
  /// after the last, another number of estimates than parts, the status kPredicted, a pose that is not finite or whose
  /// axis is no unit vector, and a covariance that is not finite or not positive definite in the five observable
  /// directions. The filter is then as it was: leave the frame out and go on.
  [[nodiscard]] std::vector<PoseEstimate> update(double timestamp_s, std::span<const PoseEstimate> measured);

  /// Where all parts will be at that time: every pixel that a part may cover whose prediction is inside the gate, and
  /// SearchRegion::kMinMarginPx around. The time may be any number of frames ahead. The whole image while a part has no
  /// confirmed track, its track is contradicted, may not go on as far as that, or leaves the view.
  /// Throws Error(kInput) for a time that is not finite or before the last update's.
  [[nodiscard]] Roi search_region(double timestamp_s) const;

  /// Forgets everything, signs and time included: as constructed.
  void reset();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace cylpose
