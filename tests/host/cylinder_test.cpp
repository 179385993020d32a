#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <cylpose/cylinder.hpp>
#include <random>

namespace cylpose {
namespace {

struct RandomScene {
  CylinderPose pose;
  double radius_m;
  double height_m;
};

RandomScene random_scene(std::mt19937& random) {
  std::uniform_real_distribution<double> unit(-1, 1);
  Eigen::Vector3d axis;
  do {
    axis = Eigen::Vector3d(unit(random), unit(random), unit(random));
  } while (axis.norm() > 1 || axis.norm() < 0.1);
  axis.normalize();
  return {{Eigen::Vector3d(unit(random), unit(random), 3 + unit(random)), axis},
          0.05 + 0.02 * unit(random),
          0.4 + 0.1 * unit(random)};
}

double distance_to_line(const Eigen::Vector3d& point, const CylinderPose& line) {
  return (point - line.center_in_cam).cross(line.axis_in_cam).norm();
}

TEST(Cylinder, TwoSidesGiveTheAxisExactly) {
  std::mt19937 random(1);
  for (int i = 0; i < 1000; ++i) {
    const RandomScene scene = random_scene(random);
    const auto planes = side_planes(scene.pose, scene.radius_m);
    ASSERT_TRUE(planes);
    const auto axis = axis_from_sides((*planes)[0], (*planes)[1], scene.radius_m);
    ASSERT_TRUE(axis);
    EXPECT_LT(axis->direction_in_cam.cross(scene.pose.axis_in_cam).norm(), 1e-11);
    EXPECT_LT(distance_to_line(axis->point_in_cam, scene.pose), 1e-10);
    EXPECT_NEAR(axis->point_in_cam.dot(axis->direction_in_cam), 0, 1e-11);
  }
}

TEST(Cylinder, SidePlanesTouchTheCylinder) {
  std::mt19937 random(2);
  const RandomScene scene = random_scene(random);
  const auto planes = side_planes(scene.pose, scene.radius_m);
  ASSERT_TRUE(planes);
  for (const Eigen::Vector3d& normal : *planes) {
    EXPECT_NEAR(normal.norm(), 1, 1e-12);
    EXPECT_NEAR(normal.dot(scene.pose.axis_in_cam), 0, 1e-12);
    EXPECT_NEAR(normal.dot(scene.pose.center_in_cam), scene.radius_m, 1e-12);
  }
}

TEST(Cylinder, OnePlaneTwiceHasNoAxis) {
  const Eigen::Vector3d normal = Eigen::Vector3d::UnitX();
  EXPECT_FALSE(axis_from_sides(normal, normal, 0.05));
  EXPECT_FALSE(axis_from_sides(normal, -normal, 0.05));
}

TEST(Cylinder, CameraInsideTheInfiniteCylinderSeesNoSides) {
  EXPECT_FALSE(side_planes({{0, 0, 2}, Eigen::Vector3d::UnitZ()}, 0.05));
}

TEST(Cylinder, PointsOfTheBaseCircleLieOnItsConic) {
  std::mt19937 random(3);
  for (int i = 0; i < 200; ++i) {
    const RandomScene scene = random_scene(random);
    const Eigen::Vector3d base = scene.pose.center_in_cam + scene.pose.axis_in_cam * scene.height_m / 2;
    const Eigen::Matrix3d conic = base_conic(base, scene.pose.axis_in_cam, scene.radius_m);
    const Eigen::Vector3d e1 = scene.pose.axis_in_cam.unitOrthogonal();
    const Eigen::Vector3d e2 = scene.pose.axis_in_cam.cross(e1);
    for (double angle = 0; angle < 6; angle += 0.5) {
      const Eigen::Vector3d on = base + scene.radius_m * (std::cos(angle) * e1 + std::sin(angle) * e2);
      const Eigen::Vector3d off = base + 1.01 * scene.radius_m * (std::cos(angle) * e1 + std::sin(angle) * e2);
      EXPECT_NEAR(on.dot(conic * on), 0, 1e-12);
      EXPECT_GT(std::abs(off.dot(conic * off)), 1e-9);
    }
  }
}

bool inside_polygon(const std::vector<Eigen::Vector2d>& polygon, const Eigen::Vector2d& p) {
  bool inside = false;
  for (std::size_t i = 0, j = polygon.size() - 1; i < polygon.size(); j = i++) {
    const Eigen::Vector2d& a = polygon[i];
    const Eigen::Vector2d& b = polygon[j];
    if ((a.y() > p.y()) != (b.y() > p.y()) && p.x() < (b.x() - a.x()) * (p.y() - a.y()) / (b.y() - a.y()) + a.x()) {
      inside = !inside;
    }
  }
  return inside;
}

// The outline and the ray caster are written independently of each other: they must agree on what is inside.
TEST(Cylinder, SilhouetteIsWhatRaysHit) {
  std::mt19937 random(4);
  int checked = 0;
  int hits = 0;
  for (int i = 0; i < 100; ++i) {
    const RandomScene scene = random_scene(random);
    const auto outline = silhouette(scene.pose, scene.radius_m, scene.height_m, 512);
    ASSERT_FALSE(outline.empty());
    const Eigen::Vector2d middle = scene.pose.center_in_cam.head<2>() / scene.pose.center_in_cam.z();
    std::uniform_real_distribution<double> around(-0.1, 0.1);
    for (int k = 0; k < 200; ++k) {
      const Eigen::Vector2d ray = middle + Eigen::Vector2d(around(random), around(random));
      double clearance = 1;
      for (const Eigen::Vector2d& p : outline) clearance = std::min(clearance, (p - ray).norm());
      if (clearance < 5e-4) continue;
      const bool hit = intersect_ray(scene.pose, scene.radius_m, scene.height_m, {ray.x(), ray.y(), 1}).has_value();
      EXPECT_EQ(hit, inside_polygon(outline, ray));
      ++checked;
      hits += hit ? 1 : 0;
    }
  }
  EXPECT_GT(checked, 10000);
  EXPECT_GT(hits, 2000);
  EXPECT_LT(hits, checked - 2000);
}

TEST(Cylinder, LookingAlongTheAxisOnlyTheNearBaseShows) {
  const CylinderPose pose{{0, 0, 2}, Eigen::Vector3d::UnitZ()};
  const auto outline = silhouette(pose, 0.05, 0.4);
  ASSERT_FALSE(outline.empty());
  for (const Eigen::Vector2d& p : outline) EXPECT_NEAR(p.norm(), 0.05 / 1.8, 1e-12);
}

TEST(Cylinder, NothingBehindTheCamera) {
  EXPECT_TRUE(silhouette({{0, 0, -2}, Eigen::Vector3d::UnitY()}, 0.05, 0.4).empty());
  EXPECT_FALSE(intersect_ray({{0, 0, -2}, Eigen::Vector3d::UnitY()}, 0.05, 0.4, {0, 0, 1}));
}

TEST(Cylinder, HitsAreOnTheSurface) {
  const CylinderPose pose{{0, 0, 2}, Eigen::Vector3d::UnitY()};
  const auto side = intersect_ray(pose, 0.05, 0.4, {0, 0, 1});
  ASSERT_TRUE(side);
  EXPECT_NEAR(side->t, 1.95, 1e-12);
  EXPECT_FALSE(side->on_base);
  EXPECT_NEAR((side->normal_in_cam - Eigen::Vector3d(0, 0, -1)).norm(), 0, 1e-12);
  const auto base = intersect_ray({{0, 0, 2}, Eigen::Vector3d::UnitZ()}, 0.05, 0.4, {0.01, 0, 1});
  ASSERT_TRUE(base);
  EXPECT_TRUE(base->on_base);
  EXPECT_NEAR(base->t, 1.8, 1e-12);
  EXPECT_NEAR(base->normal_in_cam.z(), -1, 1e-12);
}

TEST(Cylinder, SignOfTheAxisIsFixed) {
  const auto fixed = [](double x, double y, double z) { return with_fixed_sign({{}, {x, y, z}}).axis_in_cam; };
  EXPECT_EQ(fixed(0, 1, 0), Eigen::Vector3d(0, -1, 0));
  EXPECT_EQ(fixed(0.6, -0.8, 0), Eigen::Vector3d(0.6, -0.8, 0));
  EXPECT_EQ(fixed(-1, 0, 0), Eigen::Vector3d(1, 0, 0));
  EXPECT_EQ(fixed(0, 0, -1), Eigen::Vector3d(0, 0, 1));
}

}  // namespace
}  // namespace cylpose
