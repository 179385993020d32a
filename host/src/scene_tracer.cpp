#include "scene_tracer.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cylpose/error.hpp>
#include <limits>
#include <numbers>
#include <string>

#include "texture.hpp"

namespace cylpose {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kShadowGapM = 1e-6;  // keeps a surface from shading itself through rounding

// Where a ray origin + t * direction, t > 0, enters a solid.
struct Entry {
  double t;
  Eigen::Vector3d normal_in_cam;
  std::uint32_t face;
};

std::optional<Entry> enter(const CylinderSolid& cylinder, const Eigen::Vector3d& origin, const Eigen::Vector3d& ray) {
  const CylinderPose from_origin{cylinder.pose.center_in_cam - origin, cylinder.pose.axis_in_cam};
  const auto hit = intersect_ray(from_origin, cylinder.radius_m, cylinder.height_m, ray);
  if (!hit) return std::nullopt;
  return Entry{hit->t, hit->normal_in_cam, hit->on_base ? 1U : 0U};
}

std::optional<Entry> enter(const SphereSolid& sphere, const Eigen::Vector3d& origin, const Eigen::Vector3d& ray) {
  const Eigen::Vector3d center = sphere.center_in_cam - origin;
  const double a = ray.squaredNorm();
  const double b = ray.dot(center);
  const double discriminant = b * b - a * (center.squaredNorm() - sphere.radius_m * sphere.radius_m);
  if (discriminant <= 0) return std::nullopt;
  const double t = (b - std::sqrt(discriminant)) / a;
  if (t <= 0) return std::nullopt;
  return Entry{t, (t * ray - center) / sphere.radius_m, 0};
}

std::optional<Entry> enter(const BoxSolid& box, const Eigen::Vector3d& origin, const Eigen::Vector3d& ray) {
  const Eigen::Vector3d from = box.cam_from_box.transpose() * (origin - box.center_in_cam);
  const Eigen::Vector3d along = box.cam_from_box.transpose() * ray;
  double enter_t = -kInfinity;
  double leave_t = kInfinity;
  int enter_side = 0;
  for (int side = 0; side < 3; ++side) {
    const double half = box.half_size_m[side];
    if (along[side] == 0) {
      if (std::abs(from[side]) > half) return std::nullopt;
      continue;
    }
    const double toward = along[side] > 0 ? half : -half;
    const double near_t = (-toward - from[side]) / along[side];
    const double far_t = (toward - from[side]) / along[side];
    if (near_t > enter_t) {
      enter_t = near_t;
      enter_side = side;
    }
    leave_t = std::min(leave_t, far_t);
  }
  if (enter_t <= 0 || enter_t >= leave_t) return std::nullopt;
  const double outward = along[enter_side] > 0 ? -1 : 1;
  return Entry{enter_t, outward * box.cam_from_box.col(enter_side),
               static_cast<std::uint32_t>(2 * enter_side + (outward > 0 ? 1 : 0))};
}

std::optional<Entry> enter(const Solid& solid, const Eigen::Vector3d& origin, const Eigen::Vector3d& ray) {
  return std::visit([&](const auto& shape) { return enter(shape, origin, ray); }, solid.shape);
}

struct BoundingSphere {
  Eigen::Vector3d center_in_cam;
  double radius_m;
};

BoundingSphere bounds_of(const CylinderSolid& cylinder) {
  return {cylinder.pose.center_in_cam, std::hypot(cylinder.radius_m, cylinder.height_m / 2)};
}

BoundingSphere bounds_of(const SphereSolid& sphere) {
  return {sphere.center_in_cam, sphere.radius_m};
}

BoundingSphere bounds_of(const BoxSolid& box) {
  return {box.center_in_cam, box.half_size_m.norm()};
}

bool has_size(const CylinderSolid& cylinder) {
  return cylinder.radius_m > 0 && cylinder.height_m > 0 && std::abs(cylinder.pose.axis_in_cam.norm() - 1) < 1e-6 &&
         cylinder.pose.center_in_cam.allFinite();
}

bool has_size(const SphereSolid& sphere) {
  return sphere.radius_m > 0 && sphere.center_in_cam.allFinite();
}

bool has_size(const BoxSolid& box) {
  return (box.half_size_m.array() > 0).all() && box.center_in_cam.allFinite() && box.cam_from_box.isUnitary(1e-6);
}

// The range of lateral / depth over a circle of radius r: directions within asin(r / distance) of its centre.
std::array<double, 2> tangent_range(double lateral, double depth, double radius) {
  const double distance = std::hypot(lateral, depth);
  if (distance <= radius) return {-kInfinity, kInfinity};
  const double middle = std::atan2(lateral, depth);
  const double spread = std::asin(radius / distance);
  const double low = middle - spread;
  const double high = middle + spread;
  constexpr double kQuarterTurn = std::numbers::pi / 2;
  return {low > -kQuarterTurn ? std::tan(low) : -kInfinity, high < kQuarterTurn ? std::tan(high) : kInfinity};
}

Eigen::Vector2d texture_point(const Solid& solid, const Eigen::Vector3d& offset_in_cam) {
  if (const auto* box = std::get_if<BoxSolid>(&solid.shape)) {
    return (box->cam_from_box.transpose() * offset_in_cam).head<2>();
  }
  return offset_in_cam.head<2>();
}

// What roughness makes of the diffuse light, as a factor; both directions away from the surface, of unit length.
double rough_factor(double roughness_rad, const Eigen::Vector3d& normal, const Eigen::Vector3d& to_light,
                    const Eigen::Vector3d& to_camera) {
  if (roughness_rad == 0) return 1;
  const double variance = roughness_rad * roughness_rad;
  const double light_cosine = std::clamp(normal.dot(to_light), 0.0, 1.0);
  const double camera_cosine = std::clamp(normal.dot(to_camera), 0.0, 1.0);
  const Eigen::Vector3d light_beside = to_light - light_cosine * normal;
  const Eigen::Vector3d camera_beside = to_camera - camera_cosine * normal;
  const double lengths = light_beside.norm() * camera_beside.norm();
  const double azimuth_cosine = lengths > 0 ? light_beside.dot(camera_beside) / lengths : 0;
  const double steeper = std::acos(std::min(light_cosine, camera_cosine));
  const double flatter = std::acos(std::max(light_cosine, camera_cosine));
  return 1 - 0.5 * variance / (variance + 0.33) +
         0.45 * variance / (variance + 0.09) * std::max(0.0, azimuth_cosine) * std::sin(steeper) * std::tan(flatter);
}

// Share of unpolarised light that a surface mirrors (Fresnel's equations); `cosine` of its angle from the normal.
double fresnel(double refractive_index, double cosine) {
  const double inside = std::sqrt(refractive_index * refractive_index - 1 + cosine * cosine);  // index times its cosine
  const double across = (cosine - inside) / (cosine + inside);
  const double squared_index = refractive_index * refractive_index;
  const double along = (squared_index * cosine - inside) / (squared_index * cosine + inside);
  return (across * across + along * along) / 2;
}

}  // namespace

SceneTracer::SceneTracer(const Scene& scene)
    : part_count_(scene.parts.size()), lighting_(scene.lighting), background_(scene.background) {
  if (lighting_.at_infinity) lighting_.light_in_cam.normalize();
  const std::size_t count = scene.parts.size() + scene.others.size();
  for (std::size_t i = 0; i < count; ++i) {
    Bounded bounded{solid_at(scene, i), {}, 0, {}, {}};
    if (!std::visit([](const auto& shape) { return has_size(shape); }, bounded.solid.shape)) {
      throw Error(ErrorKind::kInput, "solid " + std::to_string(i) +
                                         " of the scene is no body: sizes must be above zero, the place finite, axes "
                                         "of unit length");
    }
    const BoundingSphere bounds = std::visit([](const auto& shape) { return bounds_of(shape); }, bounded.solid.shape);
    bounded.center_in_cam = bounds.center_in_cam;
    bounded.bounding_radius_m = bounds.radius_m;
    if (bounds.center_in_cam.z() < -bounds.radius_m) {
      bounded.ray_low.setConstant(kInfinity);  // behind the camera: no ray (u, v, 1) meets it, a shadow may
      bounded.ray_high.setConstant(-kInfinity);
    } else {
      for (int k = 0; k < 2; ++k) {
        const auto range = tangent_range(bounds.center_in_cam[k], bounds.center_in_cam.z(), bounds.radius_m);
        bounded.ray_low[k] = range[0];
        bounded.ray_high[k] = range[1];
      }
    }
    solids_.push_back(bounded);
  }
}

std::optional<SceneTracer::Hit> SceneTracer::first_hit(const Eigen::Vector2d& ray) const {
  std::optional<Hit> first;
  for (std::size_t i = 0; i < solids_.size(); ++i) {
    const Bounded& bounded = solids_[i];
    if (ray.x() < bounded.ray_low.x() || ray.x() > bounded.ray_high.x() || ray.y() < bounded.ray_low.y() ||
        ray.y() > bounded.ray_high.y()) {
      continue;
    }
    const auto entry = enter(bounded.solid, Eigen::Vector3d::Zero(), {ray.x(), ray.y(), 1});
    if (entry && (!first || entry->t < first->t)) {
      first = Hit{entry->t, entry->normal_in_cam, entry->face, i};
    }
  }
  return first;
}

bool SceneTracer::is_shadowed(const Eigen::Vector3d& point, const Eigen::Vector3d& to_light) const {
  const double light_distance = lighting_.at_infinity ? kInfinity : (lighting_.light_in_cam - point).norm();
  return std::any_of(solids_.begin(), solids_.end(), [&](const Bounded& bounded) {
    const Eigen::Vector3d to_center = bounded.center_in_cam - point;
    const double beside_squared = to_center.cross(to_light).squaredNorm();
    if (beside_squared > bounded.bounding_radius_m * bounded.bounding_radius_m) return false;
    const auto entry = enter(bounded.solid, point, to_light);
    return entry && entry->t < light_distance;
  });
}

LightSample SceneTracer::light_along(const Eigen::Vector2d& ray) const {
  const auto hit = first_hit(ray);
  if (!hit) {
    const TextureSample background = sample(background_, ray.x(), ray.y());
    return {background.color, background.cell};
  }
  const Bounded& bounded = solids_[hit->solid];
  const Material& material = bounded.solid.material;
  const Eigen::Vector3d direction(ray.x(), ray.y(), 1);
  const Eigen::Vector3d point = hit->t * direction;
  const Eigen::Vector2d on_texture = texture_point(bounded.solid, point - bounded.center_in_cam);
  const TextureSample texture = sample(material.texture, on_texture.x(), on_texture.y());

  const Eigen::Vector3d to_light =
      lighting_.at_infinity ? lighting_.light_in_cam : (lighting_.light_in_cam - point).normalized();
  const double facing = hit->normal_in_cam.dot(to_light);
  const bool shadowed =
      lighting_.hard_shadows && facing > 0 && is_shadowed(point + kShadowGapM * hit->normal_in_cam, to_light);
  LinearRgb light = lighting_.ambient * texture.color;
  if (facing > 0 && !shadowed) {
    light += lighting_.key * facing *
             rough_factor(material.roughness_rad, hit->normal_in_cam, to_light, -direction.normalized()) *
             texture.color;
    if (material.specular > 0) {
      const Eigen::Vector3d half_way = (to_light - direction.normalized()).normalized();
      const double mirror = std::max(0.0, hit->normal_in_cam.dot(half_way));
      light.array() += lighting_.key * material.specular * std::pow(mirror, material.exponent);
    }
  }
  if (material.refractive_index > 1) {
    const double cosine = std::clamp(-hit->normal_in_cam.dot(direction.normalized()), 0.0, 1.0);
    const double mirrored = fresnel(material.refractive_index, cosine);
    const Eigen::Vector3d onward = direction - 2 * direction.dot(hit->normal_in_cam) * hit->normal_in_cam;
    light = (1 - mirrored) * light + mirrored * light_from_afar(onward);
  }
  // Solids count from 1 here: 0 is the background. A face takes three bits.
  const auto solid = static_cast<std::uint32_t>(hit->solid + 1);
  return {light, (hit->solid < part_count_ ? kPartBit : 0U) | (solid << 5) | (hit->face << 2) | (texture.cell << 1) |
                     (shadowed ? 1U : 0U)};
}

LinearRgb SceneTracer::light_from_afar(const Eigen::Vector3d& direction) const {
  if (direction.z() <= 0) return LinearRgb::Constant(lighting_.ambient);
  return sample(background_, direction.x() / direction.z(), direction.y() / direction.z()).color;
}

std::optional<std::size_t> SceneTracer::solid_along(const Eigen::Vector2d& ray) const {
  const auto hit = first_hit(ray);
  return hit ? std::optional(hit->solid) : std::nullopt;
}

}  // namespace cylpose
