// How well a pose agrees with the edges it came from. Internal to the thesis's method.
#pragma once

#include <array>
#include <cylpose/thesis.hpp>

namespace cylpose {

/// Root mean square distance, in ideal pixels, of the lines' points (ideal pixels) from the nearer side of the
/// cylinder. Requires a camera outside the infinite cylinder.
[[nodiscard]] double thesis_rms_px(const CylinderPose& pose, double radius_m, const std::array<ThesisLine, 2>& sides,
                                   double focal_px);

/// Share of the predicted outline inside the image that has an edge pixel within two pixels.
[[nodiscard]] double thesis_seen(const CylinderPose& pose, const PartModel& part, const CameraModel& camera,
                                 const Mask& edge_image);

}  // namespace cylpose
