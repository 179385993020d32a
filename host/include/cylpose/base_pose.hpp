// Poses from the image of a base: views along the axis, where the sides are short or hidden.
#pragma once

#include <Eigen/Core>
#include <cylpose/camera.hpp>
#include <cylpose/contour.hpp>
#include <cylpose/cylinder.hpp>
#include <cylpose/edge_field.hpp>
#include <cylpose/edge_sigma.hpp>
#include <cylpose/ellipse.hpp>
#include <cylpose/part.hpp>
#include <optional>
#include <span>
#include <vector>

namespace cylpose {

/// The cylinders one of whose bases has one of these ellipses as image: per ellipse and circle pose (circle_pose.hpp)
/// one that extends away from the camera, its near base seen, and one that extends toward it. Those that reach behind
/// the camera are left out.
[[nodiscard]] std::vector<CylinderPose> poses_from_bases(const CameraModel& camera, const PartModel& part,
                                                         std::span<const FittedEllipse> ellipses);

/// The two cylinders whose outline has about the spread of the colour region: as far as its width says, tilted along
/// its long axis to one side or the other as far as its length says. Rough, and only right where all of the part is
/// seen; for views in which no base shows enough of its rim. Requires region.m00 > 0; up to two poses.
[[nodiscard]] std::vector<CylinderPose> poses_from_blob(const CameraModel& camera, const PartModel& part,
                                                        const RegionStatistics& region);

/// The view from within the infinite cylinder: the near base hides all the rest.
struct EndOnView {
  CylinderPose pose;  ///< midway between the two circle poses: they tilt to opposite sides, and nothing tells which
  Eigen::Matrix<double, 6, 6> covariance;  ///< as PoseEstimate::covariance; covers both
  double rms_px;                           ///< of the supporting points' distances from the ellipse
  int support;                             ///< number of supporting points
  double seen;  ///< share of the ellipse, counted in steps of equal angle, that a point supports or that lies outside
                ///< the image
};

/// Mean and covariance of both circle poses over the ellipse's uncertainty, at sigma points, each turned back until its
/// cylinder hides its sides. Near the face-on view, where the tilt goes with the root of what is measured, first
/// derivatives would say nothing. `common_edge_sigma` as in RefineOptions. None when at all sigma points the sides
/// would show.
[[nodiscard]] std::optional<EndOnView> end_on_view(const CameraModel& camera, const PartModel& part,
                                                   const FittedEllipse& base, std::span<const EdgePoint> points,
                                                   const CommonEdgeSigma& common_edge_sigma);

}  // namespace cylpose
