// The thesis's pose equations on exact lines: the approximation in them is known, so both its presence and its size are
// tested.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <cylpose/thesis.hpp>
#include <numbers>
#include <random>

namespace cylpose {
namespace {

constexpr double kFocalPx = 1215;
constexpr double kRadius = 0.05;

ImageLine line_of_plane(const Eigen::Vector3d& normal) {
  const double scale = normal.head<2>().norm();
  return {normal.head<2>() / scale, -kFocalPx * normal.z() / scale};
}

Eigen::Vector2d ideal_pixel(const Eigen::Vector3d& point_in_cam) {
  return kFocalPx * point_in_cam.head<2>() / point_in_cam.z();
}

std::optional<CylinderPose> pose_from_exact_lines(const CylinderPose& truth, bool swapped = false) {
  const auto planes = side_planes(truth, kRadius).value();
  return thesis_pose_from_lines(line_of_plane(planes[swapped ? 1 : 0]), line_of_plane(planes[swapped ? 0 : 1]),
                                ideal_pixel(truth.center_in_cam), kFocalPx, kRadius, nullptr);
}

// How the estimated axis lies to the true one, in units of r^2 / (2 D).
struct Deviation {
  double nearer;  // toward the camera
  double across;  // at right angles to the axis and to the direction to the camera
};

Deviation deviation(const CylinderPose& estimate, const CylinderPose& truth) {
  const Eigen::Vector3d& d = truth.axis_in_cam;
  const Eigen::Vector3d to_axis = truth.center_in_cam - d * d.dot(truth.center_in_cam);
  const double distance = to_axis.norm();
  const double unit = kRadius * kRadius / (2 * distance);
  const Eigen::Vector3d off = estimate.center_in_cam - truth.center_in_cam;
  return {-off.dot(to_axis) / distance / unit, off.dot(d.cross(to_axis)) / distance / unit};
}

CylinderPose random_pose(std::mt19937& random) {
  std::uniform_real_distribution<double> unit(-1, 1);
  const double z = 2.5 + 1.5 * unit(random);
  Eigen::Vector3d axis(unit(random), unit(random), 0.5 * unit(random));
  return with_fixed_sign({{0.2 * z * unit(random), 0.2 * z * unit(random), z}, axis.normalized()});
}

TEST(ThesisPose, AxisIsExactAndTooNearByTheKnownApproximation) {
  std::mt19937 random(1);
  for (int i = 0; i < 1000; ++i) {
    const CylinderPose truth = random_pose(random);
    for (const bool swapped : {false, true}) {
      const auto estimate = pose_from_exact_lines(truth, swapped);
      ASSERT_TRUE(estimate);
      EXPECT_NEAR((estimate->axis_in_cam - truth.axis_in_cam).norm(), 0, 1e-9);
      const Deviation off = deviation(*estimate, truth);
      EXPECT_NEAR(off.nearer, 1, 0.02);
      EXPECT_NEAR(off.across, 0, 0.02);
    }
  }
}

// With the axis through the optical axis and square to it the approximation has a closed form: the chord of length 2 r
// between the two planes has its middle at sqrt(D^2 - r^2).
TEST(ThesisPose, DepthOfACentredCylinderIsTheChords) {
  for (const double distance : {0.3, 1.5, 5.0}) {
    const auto estimate = pose_from_exact_lines({{0, 0, distance}, -Eigen::Vector3d::UnitY()});
    ASSERT_TRUE(estimate);
    EXPECT_NEAR(estimate->center_in_cam.z(), std::sqrt(distance * distance - kRadius * kRadius), 1e-8);
    EXPECT_NEAR(estimate->center_in_cam.head<2>().norm(), 0, 1e-8);
  }
}

// Far from the principal point a cylinder parallel to the image plane has parallel sides, where the equations come to
// 0/0. Any point p other than the foot of the perpendicular would be 30 mm off here.
TEST(ThesisPose, ParallelSidesFarFromThePrincipalPoint) {
  for (const Eigen::Vector3d& axis :
       {Eigen::Vector3d(0, -1, 0), Eigen::Vector3d(1, 0, 0), Eigen::Vector3d(0.6, -0.8, 0)}) {
    const CylinderPose truth{{0.3, 0.1, 1.5}, axis};
    const auto estimate = pose_from_exact_lines(truth);
    ASSERT_TRUE(estimate);
    EXPECT_NEAR(estimate->axis_in_cam.cross(axis).norm(), 0, 1e-5);  // the sign of a level axis hangs on its last digit
    const Deviation off = deviation(*estimate, truth);
    EXPECT_NEAR(off.nearer, 1, 0.02);
    EXPECT_NEAR(off.across, 0, 0.02);
  }
}

// Equations 3.24 and 3.25 take turns as the image turns; both must say the same.
TEST(ThesisPose, TurnsWithTheImage) {
  const CylinderPose upright{{0.1, 0.2, 1.5}, Eigen::Vector3d(0.1, -1, 0.3).normalized()};
  const auto reference = pose_from_exact_lines(upright);
  ASSERT_TRUE(reference);
  for (int degrees = 0; degrees < 360; degrees += 5) {
    const Eigen::Matrix3d turn =
        Eigen::AngleAxisd(degrees * std::numbers::pi / 180, Eigen::Vector3d::UnitZ()).toRotationMatrix();
    const auto estimate = pose_from_exact_lines({turn * upright.center_in_cam, turn * upright.axis_in_cam});
    ASSERT_TRUE(estimate);
    const CylinderPose expected = with_fixed_sign({turn * reference->center_in_cam, turn * reference->axis_in_cam});
    EXPECT_NEAR((estimate->center_in_cam - expected.center_in_cam).norm(), 0, 1e-9) << degrees;
    EXPECT_NEAR((estimate->axis_in_cam - expected.axis_in_cam).norm(), 0, 1e-9) << degrees;
  }
}

TEST(ThesisPose, CentreIsTheAxisPointClosestToTheRayThroughTheMean) {
  const CylinderPose truth{{0.1, -0.2, 2}, Eigen::Vector3d(0.3, -0.9, 0.4).normalized()};
  const auto planes = side_planes(truth, kRadius).value();
  const Eigen::Vector2d mean = ideal_pixel(truth.center_in_cam) + Eigen::Vector2d(20, -30);
  const auto estimate =
      thesis_pose_from_lines(line_of_plane(planes[0]), line_of_plane(planes[1]), mean, kFocalPx, kRadius, nullptr);
  ASSERT_TRUE(estimate);
  const Eigen::Vector3d ray = Eigen::Vector3d(mean.x(), mean.y(), kFocalPx).normalized();
  const auto distance_to_ray = [&](double along) {
    return (estimate->center_in_cam + along * estimate->axis_in_cam).cross(ray).norm();
  };
  EXPECT_LT(distance_to_ray(0), distance_to_ray(0.001));
  EXPECT_LT(distance_to_ray(0), distance_to_ray(-0.001));
}

TEST(ThesisPose, RefusesLinesWithoutACylinder) {
  const Eigen::Vector2d x(1, 0);
  std::string why;
  EXPECT_FALSE(thesis_pose_from_lines({x, 10}, {x, 10}, {10, 0}, kFocalPx, kRadius, &why));
  EXPECT_EQ(why, "the two side lines are one line");
  EXPECT_FALSE(thesis_pose_from_lines({x, 10}, {-x, -10}, {10, 0}, kFocalPx, kRadius, &why));
  // Both lines pass through the principal point, so both feet do: P and Q would be at the same place.
  EXPECT_FALSE(thesis_pose_from_lines({x, 0}, {Eigen::Vector2d(0.8, 0.6), 0}, {0, 100}, kFocalPx, kRadius, &why));
  EXPECT_EQ(why, "the two side lines have no cylinder of this radius in front of the camera");
  // Two sides that meet in the vanishing point (0, 100): beyond it there is nothing of the cylinder.
  const Eigen::Vector2d left = Eigen::Vector2d(1, 0.2).normalized();
  const Eigen::Vector2d right = Eigen::Vector2d(1, -0.2).normalized();
  const Eigen::Vector2d vanishing(0, 100);
  const ImageLine left_line{left, left.dot(vanishing)};
  const ImageLine right_line{right, right.dot(vanishing)};
  EXPECT_TRUE(thesis_pose_from_lines(left_line, right_line, {0, -50}, kFocalPx, kRadius, &why));
  EXPECT_FALSE(thesis_pose_from_lines(left_line, right_line, {0, 250}, kFocalPx, kRadius, &why));
  EXPECT_EQ(why, "the centre would lie behind the camera");
}

// The same lines through the pose function with offsets and turns drawn from the stated variances must spread as the
// covariance says.
TEST(ThesisPose, CovarianceIsTheSpreadOfRoundedLines) {
  const CylinderPose truth{{0.1, 0.05, 1.2}, Eigen::Vector3d(0.2, -1, 0.3).normalized()};
  const PartModel part{"part", kRadius, 0.4, 200, 260, 0.3, 0.1};
  const Eigen::Vector2d mean = ideal_pixel(truth.center_in_cam);
  std::array<ThesisLine, 2> sides;
  std::array<Eigen::Vector2d, 2> middles;
  constexpr double kLength = 300;
  const auto planes = side_planes(truth, kRadius).value();
  for (std::size_t k = 0; k < 2; ++k) {
    const ImageLine line = line_of_plane(planes[k]);
    sides[k].rho_rad = std::atan2(line.normal.y(), line.normal.x());
    sides[k].delta_px = line.distance;
    const Eigen::Vector2d direction(-line.normal.y(), line.normal.x());
    middles[k] = line.distance * line.normal + direction.dot(mean) * direction;
    sides[k].points = {middles[k] - kLength / 2 * direction, middles[k] + kLength / 2 * direction};
  }
  const auto covariance = thesis_covariance(sides, mean, kFocalPx, part);
  ASSERT_TRUE(covariance);
  EXPECT_NEAR((*covariance - covariance->transpose()).norm(), 0, 1e-12);

  std::mt19937 random(2);
  std::normal_distribution<double> normal;
  const auto nominal =
      thesis_pose_from_lines(line_of_plane(planes[0]), line_of_plane(planes[1]), mean, kFocalPx, kRadius, nullptr);
  Eigen::Matrix<double, 6, 6> spread = Eigen::Matrix<double, 6, 6>::Zero();
  constexpr int kDraws = 20000;
  for (int i = 0; i < kDraws; ++i) {
    std::array<ImageLine, 2> lines;
    for (std::size_t k = 0; k < 2; ++k) {
      const double rho = sides[k].rho_rad + normal(random) * std::sqrt(1.0 / 6) / kLength;
      lines[k].normal = {std::cos(rho), std::sin(rho)};
      lines[k].distance = lines[k].normal.dot(middles[k]) + normal(random) * std::sqrt(1.0 / 12);
    }
    const auto pose = thesis_pose_from_lines(lines[0], lines[1], mean, kFocalPx, kRadius, nullptr);
    ASSERT_TRUE(pose);
    Eigen::Matrix<double, 6, 1> off;
    off << pose->center_in_cam - nominal->center_in_cam, nominal->axis_in_cam.cross(pose->axis_in_cam);
    spread += off * off.transpose() / kDraws;
  }
  // Along the axis the covariance has its stated constants on top.
  const Eigen::Vector3d& d = nominal->axis_in_cam;
  Eigen::Matrix<double, 6, 6> expected = *covariance;
  expected.topLeftCorner<3, 3>() -= 0.4 * 0.4 / 12 * d * d.transpose();
  expected.bottomRightCorner<3, 3>() -= kUnobservableRoll * d * d.transpose();
  for (int k = 0; k < 6; ++k) EXPECT_NEAR(expected(k, k) / spread(k, k), 1, 0.08) << k;
}

}  // namespace
}  // namespace cylpose
