// When a pose is not inaccurate but wrong.
#pragma once

#include <cylpose/evaluate.hpp>
#include <optional>

#include "pose_difference.hpp"

namespace cylpose::bench {

/// A pose is wrong when it is off by more than a user could bear *and* by more than the picture excuses: beyond the
/// limits in metres or degrees, and beyond `max_sigmas` of a generous bound (edges three times as noisy as they are and
/// never better than 0.3 px). Without a bound the limits alone decide.
struct WrongRule {
  double center_share = 0.02;  ///< of the distance, but
  double center_m = 0.025;     ///< at least this; half the radius of the cylinder of the scenarios
  double axis_deg = 10;
  double max_sigmas = 6;  ///< Mahalanobis distance
};

/// Generous edge noise for that bound.
inline constexpr double kGenerousFactor = 3;
inline constexpr double kGenerousFloorPx = 0.3;

/// `sigmas`: Mahalanobis distance of the error in the generous bound. NaN counts as wrong.
[[nodiscard]] bool is_wrong(const PoseError& error, double distance_m, std::optional<double> sigmas,
                            const WrongRule& rule = {});

/// sqrt(move^T bound^-1 move).
[[nodiscard]] double mahalanobis(const Vector5d& move, const Matrix5d& bound);

}  // namespace cylpose::bench
