#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <cylpose/curved_border.hpp>
#include <cylpose/ellipse.hpp>
#include <limits>
#include <numbers>
#include <numeric>
#include <random>

namespace cylpose {
namespace {

constexpr double kPi = std::numbers::pi;

struct Shape {
  Eigen::Vector2d center;
  double a;
  double b;
  double turn;

  [[nodiscard]] EdgePoint at(double angle, double outside_px = 0) const {
    const Eigen::Rotation2Dd rotation(turn);
    const Eigen::Vector2d normal = rotation * Eigen::Vector2d(b * std::cos(angle), a * std::sin(angle)).normalized();
    return {center + rotation * Eigen::Vector2d(a * std::cos(angle), b * std::sin(angle)) + outside_px * normal,
            -normal};
  }
};

const Shape kShape{{700, 300}, 80, 55, 0.4};

// Points along the arc from..to about a pixel apart, with noise across.
std::vector<EdgePoint> arc(const Shape& shape, double from, double to, double noise_px, unsigned seed = 1) {
  std::mt19937 random(seed);
  std::normal_distribution<double> noise(0, 1);
  const int count = static_cast<int>(std::abs(to - from) * (shape.a + shape.b) / 2);
  std::vector<EdgePoint> points;
  for (int i = 0; i < count; ++i) points.push_back(shape.at(from + (to - from) * i / count, noise_px * noise(random)));
  return points;
}

std::vector<Eigen::Vector2d> positions(const std::vector<EdgePoint>& points) {
  std::vector<Eigen::Vector2d> result;
  for (const EdgePoint& point : points) result.push_back(point.position_px);
  return result;
}

Chain whole(const std::vector<EdgePoint>& points, std::size_t first = 0) {
  Chain chain(points.size() - first);
  std::iota(chain.begin(), chain.end(), static_cast<int>(first));
  return chain;
}

void expect_shape(const Ellipse& ellipse, const Shape& shape, double tolerance_px) {
  EXPECT_LT((ellipse.center_px() - shape.center).norm(), tolerance_px);
  EXPECT_NEAR(ellipse.half_axes_px().x(), shape.a, tolerance_px);
  EXPECT_NEAR(ellipse.half_axes_px().y(), shape.b, tolerance_px);
}

TEST(FitEllipse, ExactThroughExactPoints) {
  for (const double span : {2 * kPi, kPi, kPi / 2}) {
    for (int i = 0; i < 8; ++i) {
      const auto ellipse = fit_ellipse(positions(arc(kShape, i, i + span, 0)));
      ASSERT_TRUE(ellipse);
      expect_shape(*ellipse, kShape, 1e-6);
    }
  }
  const auto circle = fit_ellipse(positions(arc({{0, 0}, 40, 40, 0}, 0, 6, 0)));
  ASSERT_TRUE(circle);
  expect_shape(*circle, {{0, 0}, 40, 40, 0}, 1e-9);
}

TEST(FitEllipse, ConicAndDistancesDescribeTheShape) {
  const auto ellipse = fit_ellipse(positions(arc(kShape, 0, 2 * kPi, 0)));
  ASSERT_TRUE(ellipse);
  for (double angle = 0; angle < 6; angle += 0.5) {
    const EdgePoint on = kShape.at(angle);
    const Eigen::Vector3d homogeneous = on.position_px.homogeneous();
    EXPECT_NEAR(homogeneous.dot(ellipse->conic() * homogeneous), 0, 1e-9);
    EXPECT_NEAR(ellipse->signed_distance(on.position_px), 0, 1e-9);
    EXPECT_NEAR(ellipse->signed_distance(kShape.at(angle, 1).position_px), -1, 0.03);
    EXPECT_NEAR(ellipse->signed_distance(kShape.at(angle, -1).position_px), 1, 0.03);
    EXPECT_GT(ellipse->inward(on.position_px).dot(on.inward), 1 - 1e-9);
  }
}

TEST(FitEllipse, NoneWhereThereIsNone) {
  EXPECT_FALSE(fit_ellipse({}));
  EXPECT_FALSE(fit_ellipse(positions(arc(kShape, 0, 0.08, 0))));  // five points
  EXPECT_FALSE(fit_ellipse(std::vector<Eigen::Vector2d>(10, Eigen::Vector2d(3, 4))));
  std::vector<Eigen::Vector2d> line;
  for (int i = 0; i < 20; ++i) line.emplace_back(10.0 * i, 3.0 * i);
  EXPECT_FALSE(fit_ellipse(line));
  line[3].x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(fit_ellipse(line));
}

TEST(RefineEllipse, UnbiasedAndItsSigmaIsTrue) {
  // Over many arcs the errors of the distance at one end of the arc, in units of the stated sigma, have variance 1.
  constexpr int kRuns = 400;
  double normalised = 0;
  double mean_a = 0;
  for (unsigned seed = 0; seed < kRuns; ++seed) {
    const std::vector<EdgePoint> points = arc(kShape, 0, 4, 0.1, seed);
    const auto start = fit_ellipse(positions(points));
    ASSERT_TRUE(start);
    const auto fitted = refine_ellipse(*start, points, {});
    ASSERT_TRUE(fitted);
    EXPECT_NEAR(fitted->rms_px, 0.1, 0.03);
    const Eigen::Vector2d place = kShape.at(4.8).position_px;
    const auto distance_after = [&](int step, double sigmas) {
      Ellipse moved = fitted->ellipse;
      moved.coefficients += sigmas * fitted->sigma_steps.col(step);
      return moved.signed_distance(place);
    };
    double variance = 0;
    for (int step = 0; step < 5; ++step) {
      variance += std::pow((distance_after(step, 1) - distance_after(step, -1)) / 2, 2);
    }
    normalised += std::pow(fitted->ellipse.signed_distance(place), 2) / variance;
    mean_a += fitted->ellipse.half_axes_px().x() / kRuns;
  }
  EXPECT_GT(normalised / kRuns, 0.8);
  EXPECT_LT(normalised / kRuns, 1.3);
  EXPECT_NEAR(mean_a, kShape.a, 0.02);
}

TEST(RefineEllipse, EdgesOfASmallEllipseLieInsideOfIt) {
  const Shape small{{500, 400}, 12, 10, 0.3};
  std::vector<EdgePoint> points;
  for (int i = 0; i < 80; ++i) {
    const double angle = 2 * kPi * i / 80;
    const double along = std::hypot(small.a * std::sin(angle), small.b * std::cos(angle));
    points.push_back(small.at(angle, -inward_shift_px(small.a * small.b / std::pow(along, 3))));
  }
  const auto start = fit_ellipse(positions(points));
  ASSERT_TRUE(start);
  const auto fitted = refine_ellipse(*start, points, {});
  ASSERT_TRUE(fitted);
  expect_shape(fitted->ellipse, small, 0.005);
}

TEST(RefineEllipse, OutliersDoNotPullAndWrongSidesDoNotCount) {
  std::vector<EdgePoint> points = arc(kShape, 0, 6, 0.05);
  const auto start = fit_ellipse(positions(points));
  ASSERT_TRUE(start);
  for (std::size_t i = 0; i < points.size(); i += 6) points[i].position_px += 0.8 * points[i].inward;
  const auto fitted = refine_ellipse(*start, points, {});
  ASSERT_TRUE(fitted);
  expect_shape(fitted->ellipse, kShape, 0.1);
  for (EdgePoint& point : points) point.inward = -point.inward;
  EXPECT_FALSE(refine_ellipse(*start, points, {}));
}

TEST(FindEllipses, AnArcAmongStraightSides) {
  // The outline of a cylinder seen from nearly above: a large arc, two tangents, a small arc.
  const Shape near{{500, 400}, 75, 73, 0};
  const Shape far{{590, 400}, 51, 49.6, 0};
  std::vector<EdgePoint> points = arc(near, 1.3, 2 * kPi - 1.3, 0.05);
  const auto add_line = [&](const EdgePoint& from, const EdgePoint& to) {
    const Eigen::Vector2d along = to.position_px - from.position_px;
    for (int i = 1; i < 85; ++i) points.push_back({from.position_px + along * i / 85, from.inward});
  };
  add_line(near.at(-1.3), far.at(-1.3));
  for (const EdgePoint& point : arc(far, -1.3, 1.3, 0.05)) points.push_back(point);
  add_line(far.at(1.3), near.at(1.3));
  const std::vector<Chain> chains = {whole(points)};
  const auto ellipses = find_ellipses(points, chains, {});
  ASSERT_FALSE(ellipses.empty());
  expect_shape(ellipses[0].ellipse, near, 0.5);
  EXPECT_GT(ellipses[0].points.size(), 250U);
}

TEST(FindEllipses, OneArcInTwoPiecesIsOneEllipse) {
  std::vector<EdgePoint> points = arc(kShape, 0, 2, 0.05);
  const std::size_t second = points.size();
  for (const EdgePoint& point : arc(kShape, 3, 5, 0.05, 2)) points.push_back(point);
  std::vector<EdgePoint> first_only(points.begin(), points.begin() + static_cast<std::ptrdiff_t>(second));
  const std::vector<Chain> chains = {whole(first_only), whole(points, second)};
  const auto ellipses = find_ellipses(points, chains, {});
  ASSERT_FALSE(ellipses.empty());
  EXPECT_EQ(ellipses[0].points.size(), points.size());
}

TEST(FindEllipses, NothingInNothing) {
  EXPECT_TRUE(find_ellipses({}, {}, {}).empty());
  EllipseOptions options;
  options.max_distance_px = std::numeric_limits<double>::quiet_NaN();
  std::string why;
  EXPECT_FALSE(options.is_valid(&why));
  EXPECT_NE(why.find("max_distance_px"), std::string::npos);
}

}  // namespace
}  // namespace cylpose
