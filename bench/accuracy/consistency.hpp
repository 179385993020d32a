// Whether stated covariances are honest: the normalised estimation error squared (NEES; Bar-Shalom, Li and Kirubarajan,
// Estimation with Applications to Tracking and Navigation, 2001, section 5.4).
#pragma once

#include <cylpose/cylinder.hpp>
#include <cylpose/pose.hpp>

namespace cylpose::bench {

inline constexpr int kDegreesOfFreedom = 5;

/// e^T C^-1 e of the five parameters; chi-squared with 5 degrees of freedom where C is right. Infinite for a covariance
/// that is not positive definite. Throws Error(kInput) for an estimate without a pose.
[[nodiscard]] double nees(const PoseEstimate& estimate, const CylinderPose& truth);

/// The value below which a chi-squared variable lies with the given probability, 0 < probability < 1.
[[nodiscard]] double chi_squared_quantile(double probability, int degrees_of_freedom);

struct Band {
  double low;
  double high;
  [[nodiscard]] bool holds(double value) const { return value >= low && value <= high; }
};

/// Where the mean of the NEES of `count` independent frames lies with a probability of 95 %: quantiles of the
/// chi-squared distribution with 5 `count` degrees of freedom, divided by `count`. Throws Error(kInput) unless count >
/// 0.
[[nodiscard]] Band mean_nees_band(int count);

}  // namespace cylpose::bench
