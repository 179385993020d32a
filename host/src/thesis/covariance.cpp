// What whole pixels do to the pose. The thesis gives no uncertainty; docs/thesis.md, "Uncertainty", says what this is.
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cylpose/thesis.hpp>

namespace cylpose {
namespace {

constexpr double kPixelVariance = 1.0 / 12;  // of a number rounded to whole pixels
// Steps of the numerical derivatives, far above rounding and far below a pixel.
constexpr double kOffsetStepPx = 1e-3;
constexpr double kTurnStepRad = 1e-5;

// The support of a line as a rod: its middle and its length.
struct Rod {
  Eigen::Vector2d middle;
  double length;
};

Rod rod_of(const ThesisLine& line) {
  const Eigen::Vector2d normal = line.normal();
  const Eigen::Vector2d direction(-normal.y(), normal.x());
  const auto [first, last] = std::minmax_element(
      line.points.begin(), line.points.end(),
      [&](const Eigen::Vector2d& a, const Eigen::Vector2d& b) { return direction.dot(a) < direction.dot(b); });
  const double begin = direction.dot(*first);
  const double end = direction.dot(*last);
  return {line.delta_px * normal + (begin + end) / 2 * direction, end - begin};
}

// The line moved along its normal and turned about the middle of its support.
ImageLine moved(const ThesisLine& line, const Rod& rod, double offset_px, double turn_rad) {
  const double rho = line.rho_rad + turn_rad;
  const Eigen::Vector2d normal(std::cos(rho), std::sin(rho));
  return {normal, normal.dot(rod.middle) + offset_px};
}

}  // namespace

std::optional<Eigen::Matrix<double, 6, 6>> thesis_covariance(const std::array<ThesisLine, 2>& sides,
                                                             const Eigen::Vector2d& mean_px, double focal_px,
                                                             const PartModel& part) {
  const std::array<Rod, 2> rods = {rod_of(sides[0]), rod_of(sides[1])};
  const auto pose_at = [&](const Eigen::Vector4d& move) {
    return thesis_pose_from_lines(moved(sides[0], rods[0], move[0], move[1]),
                                  moved(sides[1], rods[1], move[2], move[3]), mean_px, focal_px, part.radius_m,
                                  nullptr);
  };
  const auto pose = pose_at(Eigen::Vector4d::Zero());
  if (!pose) return std::nullopt;
  const Eigen::Vector3d& axis = pose->axis_in_cam;

  const Eigen::Vector4d steps(kOffsetStepPx, kTurnStepRad, kOffsetStepPx, kTurnStepRad);
  Eigen::Matrix<double, 6, 4> jacobian;
  for (int k = 0; k < 4; ++k) {
    const auto ahead = pose_at(steps[k] * Eigen::Vector4d::Unit(k));
    const auto behind = pose_at(-steps[k] * Eigen::Vector4d::Unit(k));
    if (!ahead || !behind) return std::nullopt;
    // The fixed sign of the axis may jump within a step; the rotation w with w x axis = change of the axis must not.
    const auto rotation = [&](const Eigen::Vector3d& to) -> Eigen::Vector3d {
      return axis.cross(axis.dot(to) < 0 ? Eigen::Vector3d(-to) : to);
    };
    jacobian.col(k) << ahead->center_in_cam - behind->center_in_cam,
        rotation(ahead->axis_in_cam) - rotation(behind->axis_in_cam);
    jacobian.col(k) /= 2 * steps[k];
  }
  // Pixels of a side are rounded alike over long stretches (all of them when it is upright, every other one at 45
  // degrees), so more of them make neither better: the offset is that of one pixel, the turn that of a rod whose two
  // ends are rounded independently.
  const auto turn_variance = [](const Rod& rod) { return 2 * kPixelVariance / (rod.length * rod.length); };
  const Eigen::Vector4d variances(kPixelVariance, turn_variance(rods[0]), kPixelVariance, turn_variance(rods[1]));

  Eigen::Matrix<double, 6, 6> covariance = jacobian * variances.asDiagonal() * jacobian.transpose();
  const Eigen::Matrix3d along_axis = axis * axis.transpose();
  covariance.topLeftCorner<3, 3>() += part.height_m * part.height_m / 12 * along_axis;
  covariance.bottomRightCorner<3, 3>() += kUnobservableRoll * along_axis;
  return covariance;
}

}  // namespace cylpose
