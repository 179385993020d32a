// What a synthetic picture shows: solids under one light before a background. Camera optical frame (x right, y down, z
// forward), metres. render.hpp makes pictures of it.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <cylpose/camera.hpp>
#include <cylpose/cylinder.hpp>
#include <variant>
#include <vector>

namespace cylpose {

/// Light of the three colours, R G B, proportional to power; 1 fills the camera's range (code 255).
using LinearRgb = Eigen::Vector3d;

/// The light whose sRGB codes have this HSV colour: hue 0..360 degrees, saturation and value 0..1.
[[nodiscard]] LinearRgb linear_from_hsv(double hue_deg, double saturation, double value);

enum class TextureKind : std::uint8_t {
  kPlain,     ///< `color` everywhere
  kGradient,  ///< from `color` at y = -scale/2 to `second` at y = +scale/2
  kNoise,     ///< clouds of `color` and `second`, largest about `scale`
  kChecker,   ///< squares of side `scale`
  kWood,      ///< grain along x, one year ring about `scale` wide
  kFoil,      ///< crumpled metal foil: facets about `scale` wide of `color` that glint in `second`
};

/// A colour that varies over a plane.
struct Texture {
  TextureKind kind = TextureKind::kPlain;
  LinearRgb color = LinearRgb::Constant(0.5);
  LinearRgb second = LinearRgb::Zero();
  double scale = 1;        ///< in the units of the plane, > 0
  std::uint32_t seed = 0;  ///< another seed, another pattern
};

/// How a surface sends light back: ambient and diffuse by its texture's colour, and a white highlight (Blinn 1977).
struct Material {
  Texture texture;
  double specular = 0;   ///< share of the light that a mirror-like direction adds, 0..1
  double exponent = 30;  ///< the larger the smaller the highlight
  /// Spread of the slopes of a rough surface's facets, radians (Oren and Nayar 1994, without interreflection): the limb
  /// gets brighter with it. 0: diffuse as Lambert has it. Range 0..1.
  double roughness_rad = 0;
  /// Of a smooth clear coat, 1.5 for plastic or varnish, which mirrors the background: 4 % of it where it is looked at
  /// straight, all of it at the limb (Fresnel's equations, unpolarised). Below 1: none.
  double refractive_index = 0;
};

struct CylinderSolid {
  CylinderPose pose;
  double radius_m = 0;
  double height_m = 0;
};

struct SphereSolid {
  Eigen::Vector3d center_in_cam = Eigen::Vector3d::Zero();
  double radius_m = 0;
};

/// x_in_cam = cam_from_box * x_in_box + center_in_cam.
struct BoxSolid {
  Eigen::Vector3d center_in_cam = Eigen::Vector3d::Zero();
  Eigen::Matrix3d cam_from_box = Eigen::Matrix3d::Identity();  ///< rotation
  Eigen::Vector3d half_size_m = Eigen::Vector3d::Zero();
};

/// Textures lie in the x-y plane of a box's own frame; on cylinders and spheres in the x-y plane of the camera around
/// the solid's centre.
struct Solid {
  std::variant<CylinderSolid, SphereSolid, BoxSolid> shape;
  Material material;
};

/// Ambient light from everywhere and one key light without fall-off.
struct Lighting {
  double ambient = 0.25;  ///< light that a white surface sends back wherever it faces
  double key = 0.75;      ///< what the key light adds where it falls square on a white surface
  /// Direction toward the light (at infinity), or its place in metres.
  Eigen::Vector3d light_in_cam = {-0.4, -0.6, -0.7};
  bool at_infinity = true;
  bool hard_shadows = false;  ///< solids keep the key light from each other
};

/// A part to look for, with its true pose.
struct ScenePart {
  CylinderSolid cylinder;
  Material material;
};

struct Scene {
  CameraModel camera;
  Lighting lighting;
  /// Sends light by itself; lies in the plane of the normalised coordinates (u, v) of the rays, so its scale is a
  /// tangent of an angle.
  Texture background;
  std::vector<ScenePart> parts;
  std::vector<Solid> others;  ///< arm links, joints, bars, tables, distractors
};

/// The solid of a scene by one index: the parts first, then the others.
[[nodiscard]] Solid solid_at(const Scene& scene, std::size_t index);

}  // namespace cylpose
