#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <cylpose/curved_border.hpp>
#include <cylpose/ellipse.hpp>

#include "option_check.hpp"
#include "robust_sigma.hpp"

namespace cylpose {
namespace {

using Coefficients = Ellipse::Coefficients;

// cosine of 37 degrees, as for outlines
constexpr double kMinNormalCosine = 0.8;
// Flatter ellipses tell a line from a base too badly.
constexpr double kMinAxisRatio = 0.08;
// Cauchy weights fall to a half at this many sigma: 95 % efficiency for Gaussian residuals.
constexpr double kCauchyScale = 2.385;
// Edge places are rounded to 1/256 px and never better than this.
constexpr double kMinEdgeSigmaPx = 0.02;
constexpr int kRefineRounds = 4;
// Points that a direct fit is made through, and points by which fits are compared.
constexpr std::size_t kPointsPerFit = 12;
constexpr std::size_t kPointsToCompare = 120;

Eigen::Vector2d scaled(const Ellipse& ellipse, const Eigen::Vector2d& position_px) {
  return (position_px - ellipse.origin_px) / ellipse.scale_px;
}

Coefficients monomials(const Eigen::Vector2d& p) {
  Coefficients m;
  m << p.x() * p.x(), p.x() * p.y(), p.y() * p.y(), p.x(), p.y(), 1;
  return m;
}

// Gradient of q by (s, t).
Eigen::Vector2d gradient(const Coefficients& k, const Eigen::Vector2d& p) {
  return {2 * k[0] * p.x() + k[1] * p.y() + k[3], k[1] * p.x() + 2 * k[2] * p.y() + k[4]};
}

bool is_ellipse(const Coefficients& k) {
  return k.allFinite() && 4 * k[0] * k[2] > k[1] * k[1];
}

// Unit length, positive inside: the middle of an ellipse is where the squares' sum is negative.
Coefficients oriented(Coefficients k) {
  k.normalize();
  return k[0] > 0 ? Coefficients(-k) : k;
}

// The first-order distance and the normal's direction, without their roots.
bool is_near(const Ellipse& ellipse, const EdgePoint& point, double max_distance_px) {
  const Eigen::Vector2d p = scaled(ellipse, point.position_px);
  const Eigen::Vector2d slope = gradient(ellipse.coefficients, p);
  const double squared = slope.squaredNorm();
  const double value = ellipse.scale_px * ellipse.coefficients.dot(monomials(p));
  if (value * value > max_distance_px * max_distance_px * squared) return false;
  const double along = slope.dot(point.inward);
  return along > 0 && along * along >= kMinNormalCosine * kMinNormalCosine * squared;
}

Chain supporting(const Ellipse& ellipse, std::span<const EdgePoint> points, double max_distance_px) {
  Chain chain;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (is_near(ellipse, points[i], max_distance_px)) chain.push_back(static_cast<int>(i));
  }
  return chain;
}

// A direct fit through some points of a part of a chain; `first` and `length` count points, the chain starts over at
// its end when it is closed.
std::optional<Ellipse> fit_window(std::span<const EdgePoint> points, const Chain& chain, std::size_t first,
                                  std::size_t length) {
  const std::size_t count = std::min(length, kPointsPerFit);
  std::vector<Eigen::Vector2d> positions;
  positions.reserve(count);
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t at = (first + i * length / count) % chain.size();
    positions.push_back(points[static_cast<std::size_t>(chain[at])].position_px);
  }
  return fit_ellipse(positions);
}

bool is_closed(std::span<const EdgePoint> points, const Chain& chain) {
  constexpr double kGapPx = 4;
  return (points[static_cast<std::size_t>(chain.front())].position_px -
          points[static_cast<std::size_t>(chain.back())].position_px)
             .norm() < kGapPx;
}

// Fits through long and short windows of the longest chains, so that some lie on an arc alone wherever it begins and
// ends.
std::vector<Ellipse> window_fits(std::span<const EdgePoint> points, std::span<const Chain> chains,
                                 std::size_t min_length) {
  constexpr std::size_t kMaxChains = 4;
  std::vector<const Chain*> longest;
  for (const Chain& chain : chains) {
    if (chain.size() >= min_length) longest.push_back(&chain);
  }
  std::stable_sort(longest.begin(), longest.end(),
                   [](const Chain* a, const Chain* b) { return a->size() > b->size(); });
  if (longest.size() > kMaxChains) longest.resize(kMaxChains);

  std::vector<Ellipse> fits;
  for (const Chain* chain : longest) {
    const bool closed = is_closed(points, *chain);
    for (const double share : {1.0, 0.6, 0.35, 0.2}) {
      const auto length = static_cast<std::size_t>(share * static_cast<double>(chain->size()));
      if (length < min_length) break;
      const std::size_t last = closed ? chain->size() - 1 : chain->size() - length;
      for (std::size_t first = 0; first <= last; first += length / 5) {
        const auto fit = fit_window(points, *chain, first, length);
        if (fit && fit->half_axes_px().y() >= kMinAxisRatio * fit->half_axes_px().x()) fits.push_back(*fit);
        if (share == 1.0) break;
      }
    }
  }
  return fits;
}

}  // namespace

bool EllipseOptions::is_valid(std::string* why) const {
  return require_positive(max_distance_px, "ellipse.max_distance_px", why) &&
         require_at_least(min_support, 6, "ellipse.min_support", why) &&
         require_at_least(max_ellipses, 1, "ellipse.max_ellipses", why);
}

Eigen::Matrix3d Ellipse::conic() const {
  const Coefficients& k = coefficients;
  Eigen::Matrix3d form;
  form << k[0], k[1] / 2, k[3] / 2,  //
      k[1] / 2, k[2], k[4] / 2,      //
      k[3] / 2, k[4] / 2, k[5];
  Eigen::Matrix3d to_scaled;
  to_scaled << 1 / scale_px, 0, -origin_px.x() / scale_px,  //
      0, 1 / scale_px, -origin_px.y() / scale_px,           //
      0, 0, 1;
  return to_scaled.transpose() * form * to_scaled;
}

double Ellipse::signed_distance(const Eigen::Vector2d& position_px) const {
  const Eigen::Vector2d p = scaled(*this, position_px);
  return scale_px * coefficients.dot(monomials(p)) / gradient(coefficients, p).norm();
}

double Ellipse::curvature(const Eigen::Vector2d& position_px) const {
  const Eigen::Vector2d slope = gradient(coefficients, scaled(*this, position_px));
  const Coefficients& k = coefficients;
  // The second derivative along the tangent, times the slope squared.
  const double bend = 2 * (k[0] * slope.y() * slope.y() - k[1] * slope.x() * slope.y() + k[2] * slope.x() * slope.x());
  return std::abs(bend) / (scale_px * std::pow(slope.norm(), 3));
}

double Ellipse::edge_distance(const Eigen::Vector2d& position_px) const {
  return signed_distance(position_px) - inward_shift_px(curvature(position_px));
}

Eigen::Vector2d Ellipse::inward(const Eigen::Vector2d& position_px) const {
  return gradient(coefficients, scaled(*this, position_px)).normalized();
}

Eigen::Vector2d Ellipse::center_px() const {
  const Coefficients& k = coefficients;
  const double determinant = 4 * k[0] * k[2] - k[1] * k[1];
  const Eigen::Vector2d center(k[1] * k[4] - 2 * k[2] * k[3], k[1] * k[3] - 2 * k[0] * k[4]);
  return origin_px + scale_px * center / determinant;
}

Eigen::Vector2d Ellipse::half_axes_px() const {
  const Coefficients& k = coefficients;
  const double at_center = k.dot(monomials(scaled(*this, center_px())));
  const double mean = (k[0] + k[2]) / 2;
  const double spread = std::hypot(k[0] - k[2], k[1]) / 2;
  return scale_px * Eigen::Vector2d(std::sqrt(-at_center / (mean + spread)), std::sqrt(-at_center / (mean - spread)));
}

std::optional<Ellipse> fit_ellipse(std::span<const Eigen::Vector2d> positions_px) {
  if (positions_px.size() < 6) return std::nullopt;
  Ellipse ellipse;
  ellipse.origin_px.setZero();
  for (const Eigen::Vector2d& p : positions_px) ellipse.origin_px += p;
  const auto count = static_cast<double>(positions_px.size());
  ellipse.origin_px /= count;
  double squares = 0;
  for (const Eigen::Vector2d& p : positions_px) squares += (p - ellipse.origin_px).squaredNorm();
  ellipse.scale_px = std::sqrt(squares / count);
  if (!(ellipse.scale_px > 0) || !std::isfinite(ellipse.scale_px)) return std::nullopt;

  // With the scatter of all monomials split into quadratic and linear ones, the linear coefficients follow from the
  // quadratic ones, which solve a 3x3 eigenproblem under 4 k0 k2 - k1^2 = 1.
  Eigen::Matrix<double, 6, 6> scatter = Eigen::Matrix<double, 6, 6>::Zero();
  for (const Eigen::Vector2d& p : positions_px) {
    const Coefficients m = monomials(scaled(ellipse, p));
    scatter += m * m.transpose();
  }
  const Eigen::Matrix3d linear_of_quadratic =
      -scatter.bottomRightCorner<3, 3>().ldlt().solve(scatter.bottomLeftCorner<3, 3>());
  const Eigen::Matrix3d reduced = scatter.topLeftCorner<3, 3>() + scatter.topRightCorner<3, 3>() * linear_of_quadratic;
  Eigen::Matrix3d constrained;
  constrained << reduced.row(2) / 2, -reduced.row(1), reduced.row(0) / 2;
  if (!constrained.allFinite()) return std::nullopt;
  const Eigen::EigenSolver<Eigen::Matrix3d> eigen(constrained);
  for (Eigen::Index i = 0; i < 3; ++i) {
    const Eigen::Vector3d quadratic = eigen.eigenvectors().col(i).real();
    // Points on a line leave an "ellipse" of no width: not distinguishable from rounding.
    constexpr double kLeastDiscriminant = 1e-9;
    if (4 * quadratic[0] * quadratic[2] - quadratic[1] * quadratic[1] <= kLeastDiscriminant) continue;
    Coefficients k;
    k << quadratic, linear_of_quadratic * quadratic;
    ellipse.coefficients = oriented(k);
    if (is_ellipse(ellipse.coefficients) && ellipse.half_axes_px().allFinite()) return ellipse;
  }
  return std::nullopt;
}

std::optional<FittedEllipse> refine_ellipse(const Ellipse& start, std::span<const EdgePoint> points,
                                            const EllipseOptions& options) {
  FittedEllipse fitted{start, {}, 0, {}};
  Eigen::Matrix<double, 5, 5> normal;
  Eigen::Matrix<double, 6, 5> basis;
  double sigma_px = 0;
  for (int round = 0; round < kRefineRounds; ++round) {
    Ellipse& ellipse = fitted.ellipse;
    fitted.points = supporting(ellipse, points, options.max_distance_px);
    if (static_cast<int>(fitted.points.size()) < options.min_support) return std::nullopt;
    std::vector<double> residuals;
    residuals.reserve(fitted.points.size());
    double squares = 0;
    for (const int i : fitted.points) {
      residuals.push_back(ellipse.edge_distance(points[static_cast<std::size_t>(i)].position_px));
      squares += residuals.back() * residuals.back();
    }
    fitted.rms_px = std::sqrt(squares / static_cast<double>(residuals.size()));
    std::vector<double> in_any_order = residuals;
    sigma_px = std::max(kMinEdgeSigmaPx, robust_sigma(in_any_order));

    // The coefficients' length means nothing: steps across it.
    const Eigen::HouseholderQR<Coefficients> across(ellipse.coefficients);
    const Eigen::Matrix<double, 6, 6> turn = across.householderQ();
    basis = turn.rightCols<5>();
    normal.setZero();
    Eigen::Matrix<double, 5, 1> slope = Eigen::Matrix<double, 5, 1>::Zero();
    for (std::size_t i = 0; i < residuals.size(); ++i) {
      const Eigen::Vector2d p = scaled(ellipse, points[static_cast<std::size_t>(fitted.points[i])].position_px);
      const Eigen::Matrix<double, 5, 1> row =
          basis.transpose() * monomials(p) * (ellipse.scale_px / gradient(ellipse.coefficients, p).norm());
      const double in_scale = residuals[i] / (kCauchyScale * sigma_px);
      const double weight = 1 / (1 + in_scale * in_scale);
      normal += weight * row * row.transpose();
      slope += weight * residuals[i] * row;
    }
    const Coefficients moved = ellipse.coefficients - basis * normal.ldlt().solve(slope);
    if (!is_ellipse(moved)) return std::nullopt;
    ellipse.coefficients = oriented(moved);
  }
  const Eigen::LLT<Eigen::Matrix<double, 5, 5>> cholesky(normal);
  if (cholesky.info() != Eigen::Success || !fitted.ellipse.half_axes_px().allFinite()) return std::nullopt;
  // normal = L L^T, so that sigma^2 normal^-1 = (sigma L^-T) (sigma L^-T)^T.
  const Eigen::Matrix<double, 5, 5> identity = Eigen::Matrix<double, 5, 5>::Identity();
  fitted.sigma_steps = sigma_px * basis * cholesky.matrixU().solve(identity);
  return fitted;
}

std::vector<FittedEllipse> find_ellipses(std::span<const EdgePoint> points, std::span<const Chain> chains,
                                         const EllipseOptions& options) {
  const std::vector<Ellipse> fits = window_fits(points, chains, static_cast<std::size_t>(options.min_support));
  std::vector<EdgePoint> judges = thinned(points, kPointsToCompare);
  std::vector<FittedEllipse> ellipses;
  // Near how many of the judges each fit is: at most, as every ellipse found takes some away.
  std::vector<std::ptrdiff_t> counts(fits.size(), static_cast<std::ptrdiff_t>(judges.size()));
  for (int i = 0; i < options.max_ellipses; ++i) {
    const Ellipse* best = nullptr;
    std::ptrdiff_t best_count = 0;
    for (std::size_t k = 0; k < fits.size(); ++k) {
      if (counts[k] <= best_count) continue;
      counts[k] = std::count_if(judges.begin(), judges.end(),
                                [&](const EdgePoint& p) { return is_near(fits[k], p, options.max_distance_px); });
      if (counts[k] > best_count) {
        best_count = counts[k];
        best = &fits[k];
      }
    }
    if (best == nullptr) break;
    std::erase_if(judges, [&](const EdgePoint& p) { return is_near(*best, p, 2 * options.max_distance_px); });
    if (auto refined = refine_ellipse(*best, points, options)) ellipses.push_back(std::move(*refined));
  }
  return ellipses;
}

}  // namespace cylpose
