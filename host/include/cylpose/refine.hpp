// Refinement of a pose on all edge points of the outline, with its covariance.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cylpose/camera.hpp>
#include <cylpose/contour.hpp>
#include <cylpose/cylinder.hpp>
#include <cylpose/edge_sigma.hpp>
#include <cylpose/outline.hpp>
#include <cylpose/part.hpp>
#include <optional>
#include <span>
#include <string>

namespace cylpose {

struct RefineOptions {
  /// Farthest distance, in pixels, at which an edge point is taken for a place of the outline in the first round. Must
  /// cover the error of the closed-form pose; larger lets clutter in. The rounds halve it down to `final_gate_px`.
  double first_gate_px = 6;
  /// The same in the last rounds: what is farther away is not part of the outline.
  double final_gate_px = 1.5;
  /// Rounds of matching and solving on a part of the points at most; they end when the outline moves less than 0.002
  /// px. Up to three with all points follow.
  int rounds = 8;
  /// What edge points have in common, by what told where they are.
  CommonEdgeSigma common_edge_sigma;
  /// What points whose errors clump have in common in addition, in standard deviations of their clumped part: what
  /// pulls neighbours alike (texture, things behind the part) also moves the whole half.
  double common_edge_share = 1;

  [[nodiscard]] bool is_valid(std::string* why) const;
};

struct RefinedPose {
  CylinderPose pose;
  Eigen::Matrix<double, 6, 6> covariance;         ///< as PoseEstimate::covariance
  double rms_px;                                  ///< of the supporting points' distances from the outline
  int support;                                    ///< number of supporting points
  std::array<double, kOutlinePieces> piece_seen;  ///< share of each piece's stations that a point supports, 0..1; only
                                                  ///< stations inside the image count
  std::array<double, kOutlinePieces> piece_rms_px;  ///< of each piece's points; 0 where there are none
  std::array<int, kOutlinePieces> piece_stations;   ///< number of stations inside the image
};

/// A pose on the way: good enough to be compared with others.
struct CoarsePose {
  CylinderPose pose;
  int support;    ///< number of points within `final_gate_px` of the outline
  double rms_px;  ///< of their distances
};

/// The first rounds, from a closed-form pose to one that the edges support. As many points as `thinned` leaves suffice.
/// None when fewer than `kMinSupport` points support the outline or the solution leaves the field of view.
[[nodiscard]] std::optional<CoarsePose> refine_coarsely(const CameraModel& camera, const PartModel& part,
                                                        const CylinderPose& start, std::span<const EdgePoint> points,
                                                        const RefineOptions& options);

/// Minimises the distances of the edge points from the outline over the centre (3) and the axis direction (2), with
/// Cauchy weights. The first-order change of the outline with the pose is that of the contour's surface points
/// (docs/algorithm.md, "Refinement"). `start`, no farther off than `final_gate_px`, also serves as a weak prior for the
/// place along the axis, with a standard deviation of half the height, so that hidden bases leave a large variance and
/// not a singular problem. The piece `without`, if any, is taken to be hidden. None as above.
[[nodiscard]] std::optional<RefinedPose> refine_finely(const CameraModel& camera, const PartModel& part,
                                                       const CylinderPose& start, std::span<const EdgePoint> points,
                                                       const RefineOptions& options,
                                                       std::optional<OutlinePiece> without = std::nullopt);

/// Both, the first with a part of the points.
[[nodiscard]] std::optional<RefinedPose> refine(const CameraModel& camera, const PartModel& part,
                                                const CylinderPose& start, std::span<const EdgePoint> points,
                                                const RefineOptions& options);

inline constexpr int kMinSupport = 12;
/// As many points as the first rounds need.
inline constexpr std::size_t kPointsToComeNear = 250;

}  // namespace cylpose
