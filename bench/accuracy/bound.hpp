// How well a pose could be known at best: the Cramer-Rao bound of the outline.
#pragma once

#include <array>
#include <cylpose/camera.hpp>
#include <cylpose/contour.hpp>
#include <cylpose/cylinder.hpp>
#include <cylpose/outline.hpp>
#include <cylpose/part.hpp>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "pose_difference.hpp"

namespace cylpose::bench {

/// A short piece of the outline.
struct ContourSample {
  OutlinePiece piece;
  Eigen::Vector2d position_px;   ///< pixels of the ideal camera
  Eigen::Vector2d inward;        ///< unit normal, into the part
  Eigen::Vector3d point_in_cam;  ///< on the cylinder, metres
  double curvature;              ///< of the outline, 1/px
  double edge_pixels;  ///< how many edge pixels it has: one per row or column that it crosses, whichever are more
};

/// Standard deviation of single edge places, pixels, of the two sides and the two bases.
using PieceSigmas = std::array<double, kOutlinePieces>;

/// The outline inside the image, as far as `is_seen` says yes to its places. Empty for poses without an outline.
[[nodiscard]] std::vector<ContourSample> contour_samples(
    const CameraModel& camera, const PartModel& part, const CylinderPose& pose,
    const std::function<bool(const Eigen::Vector2d&)>& is_seen = [](const Eigen::Vector2d&) { return true; });

/// The least covariance that an unbiased estimate from independent edge places, one per edge pixel, can have: inverse
/// of the sum of J^T J / sigma^2, J the change of the outline's distance from a fixed place with the pose
/// (docs/algorithm.md, "Refinement"). Parameters as `difference` has them. A place along the axis that nothing shows is
/// only known to half the height, as the refinement assumes. None where there are no samples or too few kinds of them.
[[nodiscard]] std::optional<Matrix5d> pose_bound(const CameraModel& camera, const PartModel& part,
                                                 const CylinderPose& pose, std::span<const ContourSample> samples,
                                                 const PieceSigmas& sigmas);

/// Scatter of located edges about each piece of the true outline, without their bias: 1.4826 times the median absolute
/// deviation from the piece's median, among the points within 1.5 px. A piece with fewer than 20 points gets the
/// scatter of all. None where there are fewer than 20 in all.
[[nodiscard]] std::optional<PieceSigmas> edge_scatter(const Outline& truth, std::span<const EdgePoint> points);

}  // namespace cylpose::bench
