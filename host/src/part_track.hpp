// The life of one part's track: confirmed, followed, coasting, contradicted, lost.
#pragma once

#include <Eigen/Core>
#include <cylpose/part.hpp>
#include <cylpose/pose.hpp>
#include <cylpose/pose_filter.hpp>
#include <optional>

#include "motion_filter.hpp"

namespace cylpose {

/// Two filters at most: the confirmed track, and a rival that starts from a measurement which the track does not take.
/// A rival that enough measurements in a row agree with becomes the track.
class PartTrack {
 public:
  PartTrack(const PartModel& part, const FilterOptions& options) : part_(part), options_(options) {}

  /// As PoseFilter::update, for one part and a later time than before; sides of a prediction are left zero.
  [[nodiscard]] PoseEstimate update(double timestamp_s, const PoseEstimate& measured);

  /// None when there is no track, when it is contradicted, or when it may not go on as far as that.
  [[nodiscard]] std::optional<MotionFilter> predicted(double timestamp_s) const;

 private:
  void advance(double timestamp_s);
  [[nodiscard]] bool take(const PoseEstimate& measured);
  void feed_rival(const CylinderPose& pose, const Matrix6d& covariance);
  [[nodiscard]] bool may_go_on(const MotionFilter& track) const;
  [[nodiscard]] CylinderPose with_continuous_sign(CylinderPose pose) const;

  PartModel part_;
  FilterOptions options_;
  double now_s_ = 0;
  std::optional<MotionFilter> track_;
  double taken_s_ = 0;  // time of the last measurement that the track took
  int misses_ = 0;      // frames since
  std::optional<MotionFilter> rival_;
  double rival_taken_s_ = 0;
  int rival_count_ = 0;                       // measurements that agree
  std::optional<Eigen::Vector3d> last_axis_;  // of the last estimate with a pose
};

}  // namespace cylpose
