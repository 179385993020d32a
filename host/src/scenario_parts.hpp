// What the scenarios are put together from.
#pragma once

#include <Eigen/Core>
#include <cylpose/part.hpp>
#include <cylpose/scenario.hpp>
#include <cylpose/scene.hpp>
#include <string>
#include <vector>

namespace cylpose {

inline constexpr double kStandardRadiusM = 0.05;
inline constexpr double kStandardHeightM = 0.4;

[[nodiscard]] double radians(double degrees);

/// Unit axis at `angle_deg` to the line of sight through `center_in_cam`, its image turned by `turn_deg` from upright
/// toward the right.
[[nodiscard]] Eigen::Vector3d axis_at(const Eigen::Vector3d& center_in_cam, double angle_deg, double turn_deg);

/// The paint and the gate that finds it: hue +- `hue_tolerance_deg`, with floors that hold in the shade and on the
/// highlight.
struct PaintedPart {
  PartModel model;
  Material material;
};
[[nodiscard]] PaintedPart painted_part(const std::string& name, double hue_deg, double hue_tolerance_deg = 25);

[[nodiscard]] ScenePart at_pose(const PaintedPart& part, const CylinderPose& pose);

/// Matt to half glossy grey of 0..1 of white's light.
[[nodiscard]] Material grey(double light, double specular = 0);

/// A box of full sizes `size_m`, its frame turned about the line of sight by `turn_deg` (x toward y).
[[nodiscard]] Solid turned_box(const Eigen::Vector3d& center_in_cam, const Eigen::Vector3d& size_m, double turn_deg,
                               const Material& material);

/// A cylinder between two points.
[[nodiscard]] Solid rod(const Eigen::Vector3d& from_in_cam, const Eigen::Vector3d& to_in_cam, double radius_m,
                        const Material& material);

/// The sky of a robot simulator: pale blue-grey above, paler below.
[[nodiscard]] Texture pale_sky();

/// Grey clouds, for a background with structure but without hue.
[[nodiscard]] Texture grey_clouds(std::uint32_t seed);

[[nodiscard]] std::vector<Scenario> single_cases();  ///< fig5.2 to fig5.7
[[nodiscard]] std::vector<Scenario> test_series();   ///< series1 to series4
[[nodiscard]] std::vector<Scenario> hard_cases();    ///< occlusion, along and candle
[[nodiscard]] Scenario still_arm();                  ///< fig5.6
[[nodiscard]] Scenario moving_arm();                 ///< manipulator

}  // namespace cylpose
