#include "consistency.hpp"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <cylpose/error.hpp>
#include <limits>
#include <unsupported/Eigen/SpecialFunctions>

#include "pose_difference.hpp"

namespace cylpose::bench {

double nees(const PoseEstimate& estimate, const CylinderPose& truth) {
  if (estimate.status == PoseStatus::kNone) {
    throw Error(ErrorKind::kInput, "an estimate without a pose has no error; ask only for those that have one");
  }
  const Vector5d error = difference(estimate.pose, truth);
  const Eigen::LLT<Matrix5d> factors(covariance_in_basis(estimate));
  if (factors.info() != Eigen::Success) return std::numeric_limits<double>::infinity();
  return error.dot(factors.solve(error));
}

double chi_squared_quantile(double probability, int degrees_of_freedom) {
  if (!(probability > 0 && probability < 1) || degrees_of_freedom < 1) {
    throw Error(ErrorKind::kInput,
                fmt::format("no quantile {} of chi-squared with {} degrees of freedom: give 0 < probability < 1 and at "
                            "least 1 degree",
                            probability, degrees_of_freedom));
  }
  const double half = degrees_of_freedom / 2.0;
  double low = 0;
  double high = degrees_of_freedom + 40 * std::sqrt(degrees_of_freedom) + 100;
  while (high - low > 1e-9 * high) {
    const double middle = (low + high) / 2;
    (Eigen::numext::igamma(half, middle / 2) < probability ? low : high) = middle;
  }
  return (low + high) / 2;
}

Band mean_nees_band(int count) {
  if (count < 1) throw Error(ErrorKind::kInput, fmt::format("no mean of {} frames; give at least 1", count));
  const int degrees = kDegreesOfFreedom * count;
  return {chi_squared_quantile(0.025, degrees) / count, chi_squared_quantile(0.975, degrees) / count};
}

}  // namespace cylpose::bench
