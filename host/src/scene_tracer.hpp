// What a ray from the camera meets first in a scene, and the light that comes back along it.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <cylpose/scene.hpp>
#include <optional>
#include <vector>

namespace cylpose {

struct LightSample {
  LinearRgb light;
  std::uint32_t surface;  ///< differs between samples with an edge of any kind between them; has kPartBit on a part
};

inline constexpr std::uint32_t kPartBit = 1U << 31;

class SceneTracer {
 public:
  /// Throws Error(kInput) for solids without size. Keeps no reference to the scene.
  explicit SceneTracer(const Scene& scene);

  /// Light along the ray (u, v, 1).
  [[nodiscard]] LightSample light_along(const Eigen::Vector2d& ray) const;

  /// Index (solid_at) of what the ray (u, v, 1) meets first; none for the background.
  [[nodiscard]] std::optional<std::size_t> solid_along(const Eigen::Vector2d& ray) const;

 private:
  struct Bounded {
    Solid solid;
    Eigen::Vector3d center_in_cam;
    double bounding_radius_m;
    Eigen::Vector2d ray_low, ray_high;  // the solid lies within these (u, v)
  };
  struct Hit {
    double t;
    Eigen::Vector3d normal_in_cam;
    std::uint32_t face;
    std::size_t solid;
  };

  [[nodiscard]] std::optional<Hit> first_hit(const Eigen::Vector2d& ray) const;
  // Of the background where it is in front of the camera, and of ambient light behind it, as if far away.
  [[nodiscard]] LinearRgb light_from_afar(const Eigen::Vector3d& direction) const;
  [[nodiscard]] bool is_shadowed(const Eigen::Vector3d& point, const Eigen::Vector3d& to_light) const;

  std::vector<Bounded> solids_;
  std::size_t part_count_;
  Lighting lighting_;
  Texture background_;
};

}  // namespace cylpose
