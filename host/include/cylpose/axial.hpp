// Where along its axis line is the cylinder? Its bases tell, and where they are hidden, the colour region's centre of
// mass.
#pragma once

#include <cylpose/camera.hpp>
#include <cylpose/contour.hpp>
#include <cylpose/cylinder.hpp>
#include <cylpose/edge_field.hpp>
#include <cylpose/part.hpp>
#include <optional>
#include <span>
#include <vector>

namespace cylpose {

/// Where on the axis, in metres from its point nearest to the camera, the base is whose rim the ray touches: `upper` is
/// the one whose outward side is the axis's direction. None when the ray misses the infinite cylinder.
[[nodiscard]] std::optional<double> place_of_base(const AxisLine& axis, double radius_m, const Eigen::Vector3d& ray,
                                                  bool upper);

/// Candidate centres on the axis line, best supported first, at most `max_candidates`; never empty when the region is
/// not.
///
/// Every edge point on the outline of a base determines the centre exactly: its ray meets the infinite cylinder where
/// the rim is, at the near crossing for a base that is turned away and at the far one for a base that faces the camera
/// (docs/algorithm.md, "Place along the axis"). The places that many points agree on are the candidates. The last
/// candidate is the place where the outline's centre of mass comes to lie on the region's.
[[nodiscard]] std::vector<CylinderPose> candidate_centers(const CameraModel& camera, const PartModel& part,
                                                          const AxisLine& axis, std::span<const EdgePoint> points,
                                                          const RegionStatistics& region, int max_candidates);

}  // namespace cylpose
