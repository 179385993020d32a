#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cylpose/error.hpp>
#include <cylpose/pose_solver.hpp>
#include <functional>
#include <limits>
#include <numbers>
#include <string>

#include "ideal_edges.hpp"

namespace cylpose {
namespace {

using testing::axis_angle;
using testing::field_of;
using testing::ideal_edges;
using testing::IdealEdges;
using testing::random_pose;
using testing::test_camera;
using testing::test_part;

class PoseSolverTest : public ::testing::Test {
 protected:
  PoseEstimate solve(const CylinderPose& pose, const IdealEdges& how = {}) const {
    return solver.solve(field_of(camera, ideal_edges(camera, part, pose, how))).at(0);
  }

  // Noise that all of the outline bears is too much for the part of it that `is_visible`, where 0.1 px is not.
  void expect_that_a_part_must_fit_better(const CylinderPose& pose, double noise_px,
                                          const std::function<bool(const Eigen::Vector2d&)>& is_visible,
                                          const std::string& reason) const {
    IdealEdges how;
    how.noise_px = noise_px;
    EXPECT_EQ(solve(pose, how).status, PoseStatus::kOk);
    how.is_visible = is_visible;
    const PoseEstimate part_of_it = solve(pose, how);
    EXPECT_EQ(part_of_it.status, PoseStatus::kNone);
    EXPECT_THAT(part_of_it.reason, ::testing::HasSubstr(reason));
    how.noise_px = 0.1;
    EXPECT_EQ(solve(pose, how).status, PoseStatus::kOk);
  }

  CameraModel camera = test_camera();
  PartModel part = test_part();
  PoseSolver solver{camera, {part}};
};

TEST_F(PoseSolverTest, PerfectEdgesGiveThePerfectPose) {
  std::mt19937 random(11);
  for (int i = 0; i < 200; ++i) {
    const CylinderPose pose = random_pose(random, part);
    const PoseEstimate estimate = solve(pose);
    ASSERT_EQ(estimate.status, PoseStatus::kOk) << i << ": " << estimate.reason;
    EXPECT_LT((estimate.pose.center_in_cam - pose.center_in_cam).norm(), 1e-3 * pose.center_in_cam.z()) << i;
    EXPECT_LT(axis_angle(estimate.pose.axis_in_cam, pose.axis_in_cam), 0.01) << i;
    EXPECT_GT(estimate.seen, 0.9) << i;
  }
}

TEST_F(PoseSolverTest, CovarianceMatchesTheErrors) {
  std::mt19937 random(12);
  double normalised = 0;
  constexpr int kScenes = 200;
  for (int i = 0; i < kScenes; ++i) {
    const CylinderPose pose = random_pose(random, part);
    IdealEdges how;
    how.noise_px = 0.2;
    how.seed = static_cast<unsigned>(i);
    const PoseEstimate estimate = solve(pose, how);
    ASSERT_EQ(estimate.status, PoseStatus::kOk) << i << ": " << estimate.reason;
    const Eigen::Vector3d error = estimate.pose.center_in_cam - pose.center_in_cam;
    normalised += error.dot(estimate.covariance.topLeftCorner<3, 3>().ldlt().solve(error));
  }
  // Mean of chi-squared with 3 degrees of freedom; the common edge error that the covariance allows for is not in here.
  EXPECT_GT(normalised / kScenes, 0.2 * 3);
  EXPECT_LT(normalised / kScenes, 1.3 * 3);
}

TEST_F(PoseSolverTest, RollIsUnobservable) {
  const CylinderPose pose{{0.1, 0, 2}, Eigen::Vector3d(0.3, -0.9, 0.2).normalized()};
  const PoseEstimate estimate = solve(pose);
  ASSERT_EQ(estimate.status, PoseStatus::kOk);
  const Eigen::Vector3d& d = estimate.pose.axis_in_cam;
  EXPECT_NEAR(d.dot(estimate.covariance.bottomRightCorner<3, 3>() * d), kUnobservableRoll, 1e-9);
  EXPECT_LT(estimate.sigma_axis_rad(), 0.01);
}

TEST_F(PoseSolverTest, AxisHasTheFixedSign) {
  const PoseEstimate estimate = solve({{0, 0, 2}, Eigen::Vector3d(0.1, 0.9, 0.1).normalized()});
  ASSERT_EQ(estimate.status, PoseStatus::kOk);
  EXPECT_LT(estimate.pose.axis_in_cam.y(), 0);
}

TEST_F(PoseSolverTest, OneBaseHiddenTheOtherGivesTheCentre) {
  const CylinderPose pose{{0, 0, 1.5}, Eigen::Vector3d(0, -1, 0.2).normalized()};
  IdealEdges how;
  how.is_visible = [](const Eigen::Vector2d& p) { return p.y() > 300; };
  const PoseEstimate estimate = solve(pose, how);
  ASSERT_EQ(estimate.status, PoseStatus::kOk) << estimate.reason;
  EXPECT_LT((estimate.pose.center_in_cam - pose.center_in_cam).norm(), 2e-3);
}

TEST_F(PoseSolverTest, BothBasesHiddenTheCovarianceSaysSo) {
  const CylinderPose pose{{0, 0, 1.5}, -Eigen::Vector3d::UnitY()};
  IdealEdges how;
  how.noise_px = 0.05;
  how.is_visible = [](const Eigen::Vector2d& p) { return p.y() > 240 && p.y() < 500; };
  const PoseEstimate estimate = solve(pose, how);
  ASSERT_EQ(estimate.status, PoseStatus::kOk) << estimate.reason;
  EXPECT_GT(estimate.covariance(1, 1), 0.01 * 0.01);
  EXPECT_LT(estimate.covariance(0, 0), 0.001 * 0.001);
  EXPECT_LT(std::abs(estimate.pose.center_in_cam.y() - pose.center_in_cam.y()),
            3 * std::sqrt(estimate.covariance(1, 1)));
}

TEST_F(PoseSolverTest, APoseOfNoUseIsNoneByItsOwnCovariance) {
  const CylinderPose pose{{0, 0, 1.5}, -Eigen::Vector3d::UnitY()};
  IdealEdges how;
  how.noise_px = 0.05;
  const EdgeField field = field_of(camera, ideal_edges(camera, part, pose, how));
  const auto with = [&](double max_axis_sigma_deg, double max_line_sigma) {
    SolveOptions options;
    options.check.max_axis_sigma_deg = max_axis_sigma_deg;
    options.check.max_line_sigma = max_line_sigma;
    return PoseSolver(camera, {part}, options).solve(field).at(0);
  };
  const PoseEstimate usual = with(10, 0.02);
  ASSERT_EQ(usual.status, PoseStatus::kOk) << usual.reason;
  const double axis_sigma_deg = usual.sigma_axis_rad() * 180 / std::numbers::pi;
  const double line_sigma = std::sqrt(usual.covariance(2, 2)) / usual.pose.center_in_cam.norm();
  EXPECT_EQ(with(1.01 * axis_sigma_deg, 1.01 * line_sigma).status, PoseStatus::kOk);
  EXPECT_THAT(with(0.99 * axis_sigma_deg, 1).reason, ::testing::HasSubstr("the axis is known to"));
  EXPECT_THAT(with(10, 0.99 * line_sigma).reason, ::testing::HasSubstr("the distance of the axis is known to"));
}

// What is hidden cannot contradict: the less is seen, the better it must fit.
TEST_F(PoseSolverTest, HalfAnOutlineMustFitTwiceAsWell) {
  const CylinderPose pose{{0, 0, 1.5}, Eigen::Vector3d(0.2, -1, 0.3).normalized()};
  const auto half = [](const Eigen::Vector2d& p) { return p.y() < 300 || p.y() > 460; };
  expect_that_a_part_must_fit_better(pose, 0.4, half, "px off the outline");
}

TEST_F(PoseSolverTest, AlongTheAxisAPartOfTheOutlineMustFitWell) {
  const CylinderPose pose{{0.1, 0.05, 1.5}, Eigen::Vector3d(0.2, -0.1, 1).normalized()};
  const Eigen::Vector2d middle = ideal_pixel(camera, pose.center_in_cam);
  const auto both_ends = [&](const Eigen::Vector2d& p) { return std::abs(p.x() - middle.x()) > 24; };
  expect_that_a_part_must_fit_better(pose, 0.2, both_ends, "% of the outline, and edges");
}

TEST_F(PoseSolverTest, ABarAcrossTheMiddleLeavesThePose) {
  const CylinderPose pose{{0, 0, 1.5}, Eigen::Vector3d(0.2, -1, 0.2).normalized()};
  IdealEdges how;
  how.is_visible = [](const Eigen::Vector2d& p) { return p.y() < 310 || p.y() > 400; };
  const PoseEstimate estimate = solve(pose, how);
  ASSERT_EQ(estimate.status, PoseStatus::kOk) << estimate.reason;
  EXPECT_LT((estimate.pose.center_in_cam - pose.center_in_cam).norm(), 1e-3);
}

// A bar hides the upper end. Its edge runs so near to the hidden rim that it could be taken for it.
TEST_F(PoseSolverTest, ABarsEdgeBesideAHiddenRimDoesNotPull) {
  const CylinderPose pose{{0, 0, 3}, Eigen::Vector3d(0.3, -0.9, 0.3).normalized()};
  const PartEdges all = ideal_edges(camera, part, pose);
  const int top = all.edges.front().y;
  for (const int below : {4, 6, 8, 10}) {
    IdealEdges how;
    how.noise_px = 0.03;
    how.is_visible = [&](const Eigen::Vector2d& p) { return p.y() > top + below; };
    PartEdges edges = ideal_edges(camera, part, pose, how);
    const auto [left, right] = std::minmax_element(edges.edges.begin(), edges.edges.end(),
                                                   [](const EdgePixel& a, const EdgePixel& b) { return a.x < b.x; });
    const int first = left->x;
    const int last = right->x;
    std::erase_if(edges.edges, [&](const EdgePixel& edge) { return edge.y <= top + below; });
    std::vector<EdgePixel> bar;
    for (int x = first; x <= last; ++x) {
      const Eigen::Vector2d pixel(x, top + below);
      if (!intersect_ray(pose, part.radius_m, part.height_m, ideal_ray(camera, pixel))) continue;
      bar.push_back({static_cast<std::int16_t>(x), static_cast<std::int16_t>(top + below), 0, 800, 0,
                     EdgeStrength::kStrong, EdgeCue::kShare});
    }
    edges.edges.insert(edges.edges.begin(), bar.begin(), bar.end());
    const PoseEstimate estimate = solver.solve(field_of(camera, edges)).at(0);
    ASSERT_EQ(estimate.status, PoseStatus::kOk) << estimate.reason;
    EXPECT_LT(estimate.rms_px, 0.05) << below;  // with the bar's edge 0.08 px and more
    EXPECT_LT((estimate.pose.center_in_cam - pose.center_in_cam).norm(), 1e-3) << below;
  }
}

TEST_F(PoseSolverTest, PartlyOutsideTheImage) {
  const CylinderPose pose{{0.05, -0.35, 1.2}, Eigen::Vector3d(0.1, -1, 0.1).normalized()};
  const PoseEstimate estimate = solve(pose);
  ASSERT_EQ(estimate.status, PoseStatus::kOk) << estimate.reason;
  EXPECT_LT((estimate.pose.center_in_cam - pose.center_in_cam).norm(), 2e-3);
}

TEST_F(PoseSolverTest, DistortedEdgesGiveTheSamePose) {
  CameraModel distorted = camera;
  distorted.distortion_model = DistortionModel::kPlumbBob;
  distorted.distortion = {-0.2, 0.05, 0.001, -0.0005, 0};
  const PoseSolver with_lens(distorted, {part});
  const CylinderPose pose{{0.3, 0.1, 1.5}, Eigen::Vector3d(0.4, -1, 0.2).normalized()};
  PartEdges edges = ideal_edges(camera, part, pose);
  std::vector<EdgePixel> moved;
  for (const EdgePixel& edge : edges.edges) {
    const Eigen::Vector2d inward = Eigen::Vector2d(edge.gx, edge.gy).normalized();
    const Eigen::Vector2d ideal = Eigen::Vector2d(edge.x, edge.y) + inward * (edge.offset_256 / 256.0);
    const Eigen::Vector2d seen = project(distorted, ideal_ray(camera, ideal));
    EdgePixel pixel = edge;
    pixel.x = static_cast<std::int16_t>(std::lround(seen.x()));
    pixel.y = static_cast<std::int16_t>(std::lround(seen.y()));
    // The part of the displacement along the border does not matter.
    pixel.offset_256 =
        static_cast<std::int16_t>(std::lround(256 * inward.dot(seen - Eigen::Vector2d(pixel.x, pixel.y))));
    moved.push_back(pixel);
  }
  std::sort(moved.begin(), moved.end(),
            [](const EdgePixel& a, const EdgePixel& b) { return std::pair(a.y, a.x) < std::pair(b.y, b.x); });
  moved.erase(std::unique(moved.begin(), moved.end(),
                          [](const EdgePixel& a, const EdgePixel& b) { return a.y == b.y && a.x == b.x; }),
              moved.end());
  edges.edges = moved;
  const PoseEstimate estimate = with_lens.solve(field_of(camera, edges)).at(0);
  ASSERT_EQ(estimate.status, PoseStatus::kOk) << estimate.reason;
  EXPECT_LT((estimate.pose.center_in_cam - pose.center_in_cam).norm(), 3e-3);
}

// Axis `angle` radians off the line of sight, all of the part in the picture.
CylinderPose pose_along_sight(std::mt19937& random, const CameraModel& camera, const PartModel& part, double angle) {
  std::uniform_real_distribution<double> unit(0, 1);
  while (true) {
    const Eigen::Vector2d place(camera.width * unit(random), camera.height * unit(random));
    const Eigen::Vector3d sight = ideal_ray(camera, place).normalized();
    const Eigen::Vector3d across = Eigen::AngleAxisd(6.3 * unit(random), sight) * sight.unitOrthogonal();
    const CylinderPose pose{(0.6 + 3.4 * unit(random)) * sight, Eigen::AngleAxisd(angle, across) * sight};
    bool inside = true;
    for (const Eigen::Vector2d& ray : silhouette(pose, part.radius_m, part.height_m)) {
      const Eigen::Vector2d p = ideal_pixel(camera, {ray.x(), ray.y(), 1});
      inside = inside && p.x() > 10 && p.y() > 10 && p.x() < camera.width - 11 && p.y() < camera.height - 11;
    }
    if (inside) return pose;
  }
}

TEST_F(PoseSolverTest, ViewsAlongTheAxis) {
  std::mt19937 random(14);
  std::uniform_real_distribution<double> angle(0, 28 * std::numbers::pi / 180);
  constexpr int kScenes = 300;
  int found = 0;
  for (int i = 0; i < kScenes; ++i) {
    const CylinderPose pose = pose_along_sight(random, camera, part, angle(random));
    IdealEdges how;
    how.noise_px = 0.1;
    how.seed = static_cast<unsigned>(i);
    const PoseEstimate estimate = solve(pose, how);
    if (estimate.status != PoseStatus::kOk) continue;
    ++found;
    EXPECT_LT(axis_angle(estimate.pose.axis_in_cam, pose.axis_in_cam), 0.17) << i;
    EXPECT_LT((estimate.pose.center_in_cam - pose.center_in_cam).norm(), 0.01 * pose.center_in_cam.z() + 0.01) << i;
  }
  EXPECT_GE(found, 0.97 * kScenes);
}

TEST_F(PoseSolverTest, FromWithinTheInfiniteCylinderTheCovarianceCoversBothTilts) {
  // Nothing tells to which side the axis tilts: as good a pose as any lies in the middle, and the truth within the
  // covariance around it.
  std::mt19937 random(15);
  double normalised = 0;
  constexpr int kScenes = 200;
  int end_on = 0;
  for (int i = 0; i < kScenes; ++i) {
    const CylinderPose pose = pose_along_sight(random, camera, part, 0.008);
    IdealEdges how;
    how.noise_px = 0.1;
    how.seed = static_cast<unsigned>(i);
    const PoseEstimate estimate = solve(pose, how);
    ASSERT_EQ(estimate.status, PoseStatus::kOk) << i << ": " << estimate.reason;
    // In three of a thousand noise shows a tilt that it has not: three sigma.
    if (estimate.sides[0].normal != Eigen::Vector2d::Zero()) continue;
    ++end_on;
    const Eigen::Vector3d error = estimate.pose.center_in_cam - pose.center_in_cam;
    normalised += error.dot(estimate.covariance.topLeftCorner<3, 3>().ldlt().solve(error));
    EXPECT_LT(axis_angle(estimate.pose.axis_in_cam, pose.axis_in_cam), 4 * estimate.sigma_axis_rad() + 0.003) << i;
    EXPECT_LT(estimate.sigma_axis_rad(), 0.1) << i;
  }
  EXPECT_GE(end_on, 0.99 * kScenes);
  EXPECT_LT(normalised / end_on, 1.5 * 3);
}

TEST_F(PoseSolverTest, FarAwayTheTiltIsNotMirrored) {
  // At 5 m only half a pixel of perspective tells a tilt from its mirror image: sure, or no pose.
  const auto found_of_100 = [&](double noise_px) {
    std::mt19937 random(16);
    std::uniform_real_distribution<double> unit(-1, 1);
    int found = 0;
    for (unsigned scenes = 0; scenes < 100;) {
      // One draw a statement: compilers differ in the order of arguments.
      const double z = unit(random);
      const double y = unit(random);
      const double x = unit(random);
      const double right = 0.8 * unit(random);
      const double down = 0.4 * unit(random);
      const CylinderPose pose{{right, down, 4.9}, Eigen::Vector3d(x, y, z).normalized()};
      if (axis_angle(pose.axis_in_cam, pose.center_in_cam) < 0.52) continue;
      IdealEdges how;
      how.noise_px = noise_px;
      how.seed = ++scenes;
      const PoseEstimate estimate = solve(pose, how);
      if (estimate.status != PoseStatus::kOk) continue;
      ++found;
      EXPECT_LT(axis_angle(estimate.pose.axis_in_cam, pose.axis_in_cam), std::max(0.17, 3 * estimate.sigma_axis_rad()))
          << noise_px << " px, scene " << scenes;
    }
    return found;
  };
  EXPECT_GE(found_of_100(0.1), 95);
  EXPECT_GE(found_of_100(0.2), 80);
  EXPECT_LE(found_of_100(0.5), 60);  // nobody could be sure
}

TEST_F(PoseSolverTest, NothingGivesNoneAndAReason) {
  const PoseEstimate estimate = solver.solve(field_of(camera, {})).at(0);
  EXPECT_EQ(estimate.status, PoseStatus::kNone);
  EXPECT_NE(estimate.reason.find("colour"), std::string::npos);
}

TEST_F(PoseSolverTest, ACylinderOfAnotherShapeIsNoCylinderOfOurs) {
  PartModel longer = part;
  longer.height_m = 3 * part.height_m;
  const CylinderPose pose{{0, 0, 3}, -Eigen::Vector3d::UnitY()};
  const PoseEstimate estimate = solver.solve(field_of(camera, ideal_edges(camera, longer, pose))).at(0);
  EXPECT_EQ(estimate.status, PoseStatus::kNone);
  EXPECT_FALSE(estimate.reason.empty());
}

TEST_F(PoseSolverTest, APartOfTheSameColourAndAnotherSizeIsNotTaken) {
  // Were the far end hidden, a shorter and thinner cylinder nearer by would be the same picture; but it shows its end.
  PartModel small = part;
  small.radius_m = 0.03;
  small.height_m = 0.3;
  const PoseSolver for_small(camera, {small});
  std::mt19937 random(17);
  for (int i = 0; i < 60; ++i) {
    const CylinderPose pose = random_pose(random, part);
    if (axis_angle(pose.axis_in_cam, pose.center_in_cam) > 1.3) continue;  // the rims are straight lines
    IdealEdges how;
    how.noise_px = 0.1;
    const PoseEstimate estimate = for_small.solve(field_of(camera, ideal_edges(camera, part, pose, how))).at(0);
    EXPECT_EQ(estimate.status, PoseStatus::kNone) << i;
  }
}

TEST_F(PoseSolverTest, RandomDotsAreNoCylinder) {
  std::mt19937 random(13);
  std::uniform_int_distribution<int> coordinate(0, 700);
  std::uniform_int_distribution<int> gradient(-500, 500);
  for (int i = 0; i < 20; ++i) {
    std::map<std::pair<int, int>, EdgePixel> pixels;
    for (int k = 0; k < 4000; ++k) {
      const auto x = static_cast<std::int16_t>(coordinate(random));
      const auto y = static_cast<std::int16_t>(coordinate(random));
      pixels[{y, x}] = {x, y, static_cast<std::int16_t>(gradient(random) + 1000), 0, 0, EdgeStrength::kStrong};
    }
    PartEdges edges;
    for (const auto& [place, pixel] : pixels) edges.edges.push_back(pixel);
    edges.region.add(300, 300);
    edges.region.add(400, 400);
    EXPECT_EQ(solver.solve(field_of(camera, edges)).at(0).status, PoseStatus::kNone);
  }
}

TEST_F(PoseSolverTest, TraceShowsWhatTheStagesSaw) {
  const CylinderPose pose{{0, 0, 1.5}, -Eigen::Vector3d::UnitY()};
  StageTrace trace;
  std::vector<StageTime> times;
  (void)solver.solve(field_of(camera, ideal_edges(camera, part, pose)), &trace, &times);
  ASSERT_EQ(trace.parts.size(), 1U);
  EXPECT_GT(trace.parts[0].edges.size(), 500U);
  EXPECT_FALSE(trace.parts[0].chains.empty());
  EXPECT_GE(trace.parts[0].segments.size(), 2U);
  EXPECT_GE(trace.parts[0].lines.size(), 2U);
  ASSERT_EQ(times.size(), 5U);
  EXPECT_EQ(times[0].stage, "hysteresis");
}

TEST_F(PoseSolverTest, RefusesWhatCannotBeSolved) {
  EXPECT_THROW((void)solver.solve(EdgeField{}), Error);
  PartModel bad = part;
  bad.radius_m = -1;
  EXPECT_THROW(PoseSolver(camera, {bad}), Error);
  SolveOptions options;
  options.check.min_seen = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(PoseSolver(camera, {part}, options), Error);
  CameraModel uncalibrated = camera;
  uncalibrated.fx = 0;
  EXPECT_THROW(PoseSolver(uncalibrated, {part}), Error);
}

}  // namespace
}  // namespace cylpose
