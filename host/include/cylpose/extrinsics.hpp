// Where the camera sits on what carries it: a chaser, a robot.
#pragma once

#include <Eigen/Core>
#include <cylpose/pose.hpp>
#include <filesystem>

namespace cylpose {

/// x_in_body = body_from_cam * x_in_cam + cam_in_body, metres.
struct Extrinsics {
  Eigen::Matrix3d body_from_cam = Eigen::Matrix3d::Identity();  ///< rotation
  Eigen::Vector3d cam_in_body = Eigen::Vector3d::Zero();        ///< the camera's centre
};

/// Reads `rotation` (a unit quaternion [x, y, z, w], or three rows of three) and `translation_m` from a YAML file.
/// Throws Error(kInput) that names file, key, value and remedy, also for what is no rotation.
[[nodiscard]] Extrinsics load_extrinsics(const std::filesystem::path& path);

/// The same estimates with centre, axis and covariance in the body's frame, the axis's sign fixed there; what is in
/// pixels stays. Members called `..._in_cam` then hold body coordinates: for writing, not for estimating on.
[[nodiscard]] FrameEstimate in_body(FrameEstimate estimate, const Extrinsics& extrinsics);

}  // namespace cylpose
