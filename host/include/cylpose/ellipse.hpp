// Ellipses fitted into edge points: what the bases of a cylinder look like.
#pragma once

#include <Eigen/Core>
#include <cylpose/contour.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace cylpose {

/// An ellipse in pixels of the ideal camera, as the zero set of a quadratic form that is positive inside. Coefficients
/// belong to coordinates centred on and scaled to the fitted points, in which they are well conditioned:
/// q(s, t) = k0 s^2 + k1 s t + k2 t^2 + k3 s + k4 t + k5 with (s, t) = ((x, y) - origin_px) / scale_px, |k| = 1.
struct Ellipse {
  using Coefficients = Eigen::Matrix<double, 6, 1>;

  Coefficients coefficients;
  Eigen::Vector2d origin_px;
  double scale_px;

  /// The symmetric C with (x, y, 1) C (x, y, 1)^T = q, in pixels.
  [[nodiscard]] Eigen::Matrix3d conic() const;

  /// Pixels, positive inside; to first order (Sampson 1982), so exact on the ellipse and good within some pixels of it.
  [[nodiscard]] double signed_distance(const Eigen::Vector2d& position_px) const;

  /// 1/px, at a place near the ellipse.
  [[nodiscard]] double curvature(const Eigen::Vector2d& position_px) const;

  /// Of an edge point, from where edges of this border are located (curved_border.hpp): pixels, positive inside.
  [[nodiscard]] double edge_distance(const Eigen::Vector2d& position_px) const;

  /// Unit normal at a place near the ellipse, pointing inside.
  [[nodiscard]] Eigen::Vector2d inward(const Eigen::Vector2d& position_px) const;

  [[nodiscard]] Eigen::Vector2d center_px() const;

  /// Half the longer and half the shorter axis, pixels.
  [[nodiscard]] Eigen::Vector2d half_axes_px() const;
};

/// The direct least squares fit: Halir and Flusser's numerically stable form (1998) of Fitzgibbon, Pilu and Fisher's.
/// Always an ellipse where it gives anything, also through an arc; through a short, noisy arc too small a one. None for
/// fewer than six points, points on a line and numbers that are not finite.
[[nodiscard]] std::optional<Ellipse> fit_ellipse(std::span<const Eigen::Vector2d> positions_px);

/// An ellipse that edge points lie on, with the points' inward sides on its inner side.
struct FittedEllipse {
  Ellipse ellipse;
  Chain points;   ///< indices of the supporting edge points
  double rms_px;  ///< of their distances
  /// Five steps of the coefficients of one standard deviation each, in orthogonal directions: their covariance is
  /// sigma_steps sigma_steps^T. From the residuals; what all points have in common is not in it.
  Eigen::Matrix<double, 6, 5> sigma_steps;
};

struct EllipseOptions {
  /// Distance from the ellipse, in pixels, up to which an edge point supports it (> 0).
  double max_distance_px = 1;
  /// Least number of supporting points. At least 6.
  int min_support = 16;
  /// How many ellipses are returned at most (>= 1).
  int max_ellipses = 3;

  [[nodiscard]] bool is_valid(std::string* why) const;
};

/// The refined fit: least squares of the first-order distances with Cauchy weights, starting from `start`, over all
/// points near it whose inward side agrees. None when fewer than `min_support` do.
[[nodiscard]] std::optional<FittedEllipse> refine_ellipse(const Ellipse& start, std::span<const EdgePoint> points,
                                                          const EllipseOptions& options);

/// Ellipses of which the longest chains hold an arc, the best supported first: direct fits through windows of every
/// length; the one that most points of all chains lie on is refined, its points are put aside, and so on. Straight
/// pieces support no ellipse for long.
[[nodiscard]] std::vector<FittedEllipse> find_ellipses(std::span<const EdgePoint> points, std::span<const Chain> chains,
                                                       const EllipseOptions& options);

}  // namespace cylpose
