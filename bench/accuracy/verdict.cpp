#include "verdict.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace cylpose::bench {

bool is_wrong(const PoseError& error, double distance_m, std::optional<double> sigmas, const WrongRule& rule) {
  const double center_limit = std::max(rule.center_m, rule.center_share * distance_m);
  // Written so that NaN does not pass.
  const bool bearable = error.position_m <= center_limit && error.axis_angle_deg <= rule.axis_deg;
  const bool excused = sigmas && *sigmas <= rule.max_sigmas;
  return !bearable && !excused;
}

double mahalanobis(const Vector5d& move, const Matrix5d& bound) {
  return std::sqrt(move.dot(bound.ldlt().solve(move)));
}

}  // namespace cylpose::bench
