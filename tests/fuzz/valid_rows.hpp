// What holds for every row that a reader of poses or truth gives.
#pragma once

#include <algorithm>
#include <cmath>
#include <cylpose/pose_io.hpp>
#include <vector>

#include "refusal.hpp"

namespace cylpose::fuzz {

inline bool is_valid(const CylinderPose& pose) {
  return pose.center_in_cam.allFinite() && std::abs(pose.axis_in_cam.norm() - 1) < 1e-9;
}

inline bool is_valid(const TruthRow& row) {
  return row.frame >= 0 && is_valid(row.pose);
}

inline bool is_valid(const PoseRow& row) {
  if (row.frame < 0 || !std::isfinite(row.timestamp_s)) return false;
  if (row.status == PoseStatus::kNone) return true;
  return is_valid(row.pose) && row.sigma_center_m.allFinite() && std::isfinite(row.sigma_axis_deg) &&
         std::isfinite(row.rms_px);
}

template <typename Row>
void require_valid(const std::vector<Row>& rows) {
  require(std::all_of(rows.begin(), rows.end(), [](const Row& row) { return is_valid(row); }), "every row is valid");
}

}  // namespace cylpose::fuzz
