// A standard deviation that outliers do not move.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <span>

namespace cylpose {

/// 1.4826 times the median absolute residual: the standard deviation of Gaussian ones. At least one residual; they are
/// left absolute and in another order.
[[nodiscard]] inline double robust_sigma(std::span<double> residuals) {
  for (double& residual : residuals) residual = std::abs(residual);
  const auto middle = residuals.begin() + static_cast<std::ptrdiff_t>(residuals.size() / 2);
  std::nth_element(residuals.begin(), middle, residuals.end());
  return 1.4826 * *middle;
}

}  // namespace cylpose
