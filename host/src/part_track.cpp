#include "part_track.hpp"

#include <cylpose/cylinder.hpp>
#include <numbers>

namespace cylpose {

PoseEstimate PartTrack::update(double timestamp_s, const PoseEstimate& measured) {
  advance(timestamp_s);
  PoseEstimate estimate = measured;
  if (measured.status == PoseStatus::kOk && take(measured)) {
    misses_ = 0;
    taken_s_ = now_s_;
    estimate.pose = track_->pose();
    estimate.covariance = track_->covariance();
  } else if (track_ && may_go_on(*track_)) {
    ++misses_;
    estimate = {};
    estimate.status = PoseStatus::kPredicted;
    estimate.reason = measured.status == PoseStatus::kNone ? measured.reason : "measured pose not confirmed";
    estimate.pose = track_->pose();
    estimate.covariance = track_->covariance();
  } else {
    track_.reset();
    estimate.pose = with_continuous_sign(measured.pose);
  }
  if (estimate.status != PoseStatus::kNone) last_axis_ = estimate.pose.axis_in_cam;
  return estimate;
}

std::optional<MotionFilter> PartTrack::predicted(double timestamp_s) const {
  if (!track_ || rival_ || timestamp_s - taken_s_ > options_.max_coast_s) return std::nullopt;
  MotionFilter track = *track_;
  track.predict(timestamp_s - now_s_);
  if (!may_go_on(track)) return std::nullopt;
  return track;
}

void PartTrack::advance(double timestamp_s) {
  if (timestamp_s - taken_s_ > options_.max_coast_s) track_.reset();
  if (timestamp_s - rival_taken_s_ > options_.max_coast_s) rival_.reset();
  if (track_) track_->predict(timestamp_s - now_s_);
  if (rival_) rival_->predict(timestamp_s - now_s_);
  now_s_ = timestamp_s;
}

bool PartTrack::take(const PoseEstimate& measured) {
  const Matrix6d covariance = options_.covariance_scale * measured.covariance;
  const bool in_gate = track_ && track_->distance2(measured.pose, covariance) <= options_.gate_chi2;
  // Behind an occluder the gate grows until nearly anything fits: then one measurement is not enough.
  if (in_gate && misses_ < options_.confirm_frames) {
    track_->update(measured.pose, covariance);
    rival_.reset();
    return true;
  }
  feed_rival(measured.pose, covariance);
  const bool contradicts = track_ && !in_gate;
  if (rival_count_ < (contradicts ? options_.switch_frames : options_.confirm_frames)) return false;
  track_ = rival_;
  rival_.reset();
  return true;
}

void PartTrack::feed_rival(const CylinderPose& pose, const Matrix6d& covariance) {
  if (rival_ && rival_->distance2(pose, covariance) <= options_.gate_chi2) {
    rival_->update(pose, covariance);
    ++rival_count_;
  } else {
    rival_.emplace(with_continuous_sign(pose), covariance, options_);
    rival_count_ = 1;
  }
  rival_taken_s_ = now_s_;
}

bool PartTrack::may_go_on(const MotionFilter& track) const {
  return track.center_sigma_m() <= options_.max_center_sigma_m &&
         track.axis_sigma_rad() <= options_.max_axis_sigma_deg * std::numbers::pi / 180 &&
         !silhouette(track.pose(), part_.radius_m, part_.height_m).empty();  // empty behind the camera
}

CylinderPose PartTrack::with_continuous_sign(CylinderPose pose) const {
  if (last_axis_ && last_axis_->dot(pose.axis_in_cam) < 0) pose.axis_in_cam = -pose.axis_in_cam;
  return pose;
}

}  // namespace cylpose
