// What cylpose says about one part in one frame.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <cylpose/cylinder.hpp>
#include <cylpose/edge_field.hpp>
#include <cylpose/image.hpp>
#include <cylpose/image_line.hpp>
#include <string>
#include <string_view>
#include <vector>

namespace cylpose {

enum class PoseStatus : std::uint8_t {
  kNone,       ///< no cylinder found, or none that passed the self-check; `reason` says which test failed
  kOk,         ///< measured in this frame
  kPredicted,  ///< from the filter only
};

[[nodiscard]] std::string_view to_string(PoseStatus status);

struct PoseEstimate {
  PoseStatus status = PoseStatus::kNone;
  std::string reason;  ///< for kNone and kPredicted: the test that fired, in words

  CylinderPose pose;  ///< valid unless kNone; sign of the axis fixed (with_fixed_sign), or continuous (PoseFilter)

  /// Covariance of (x, y, z of the centre in metres, then rotations about the fixed x, y, z axes of the camera frame in
  /// radians). Rank 5 would be the truth: the unobservable roll about the axis has the variance kUnobservableRoll.
  Eigen::Matrix<double, 6, 6> covariance = Eigen::Matrix<double, 6, 6>::Zero();

  double rms_px = 0;  ///< root mean square distance of the supporting edge points from the predicted outline
  int support = 0;    ///< number of supporting edge points
  double seen = 0;    ///< share of the predicted outline inside the image that edge points support, 0..1

  /// Pixels of the ideal camera; valid unless kNone. Normals are zero where no side is seen: in views along the axis.
  std::array<ImageLine, 2> sides{ImageLine{Eigen::Vector2d::Zero(), 0}, ImageLine{Eigen::Vector2d::Zero(), 0}};

  [[nodiscard]] double sigma_axis_rad() const;  ///< root of the larger variance of the axis direction
};

/// Variance, in rad^2, written for the rotation about the axis: the full circle, (2 pi)^2 / 12.
inline constexpr double kUnobservableRoll = 3.289868133696453;

/// Everything about one frame, as the estimators return it.
struct FrameEstimate {
  Roi searched;
  std::vector<PoseEstimate> parts;  ///< one per part model, in its order
  std::vector<StageTime> times;
};

}  // namespace cylpose
