#include "rounded_end.hpp"

#include <Eigen/QR>
#include <cmath>

namespace cylpose {

double rounded_end_px(std::span<const EdgePoint> points, const Eigen::Vector2d& outward) {
  constexpr Eigen::Index kLeastPoints = 6;
  constexpr double kMaxShareOfLine = 0.5;  // of a line's residuals: what is left to the parabola
  const auto count = static_cast<Eigen::Index>(points.size());
  if (count < kLeastPoints) return 0;
  const Eigen::Vector2d across(-outward.y(), outward.x());
  Eigen::VectorXd along(count);
  Eigen::VectorXd place(count);
  for (Eigen::Index i = 0; i < count; ++i) {
    const Eigen::Vector2d& position = points[static_cast<std::size_t>(i)].position_px;
    along[i] = outward.dot(position);
    place[i] = across.dot(position);
  }
  const double half_length = (place.maxCoeff() - place.minCoeff()) / 2;
  if (!(half_length > 0)) return 0;
  place.array() = (place.array() - (place.maxCoeff() + place.minCoeff()) / 2) / half_length;
  Eigen::MatrixX3d powers(count, 3);
  powers << Eigen::VectorXd::Ones(count), place, place.cwiseAbs2();
  const auto residual = [&](const auto& columns) {
    return (along - columns * columns.householderQr().solve(along)).norm();
  };
  const Eigen::MatrixXd linear = powers.leftCols(2);
  if (residual(powers) > kMaxShareOfLine * residual(linear)) return 0;
  const Eigen::Vector3d parabola = powers.householderQr().solve(along);
  return std::max(0.0, -parabola[2]);
}

}  // namespace cylpose
