#include "pose_trial.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cylpose/error.hpp>
#include <cylpose/scenario.hpp>
#include <iterator>
#include <numbers>
#include <utility>

#include "random_place.hpp"

namespace cylpose::bench {
namespace {

constexpr std::array kDistancesM = {1.0, 1.5, 3.0, 5.0};
constexpr std::array kOcclusions = {0, 25, 50};
constexpr std::array kKinds = {"grey", "coloured", "black sky", "foil", "near hue", "clutter"};

// Farther from the part than this nothing matters, but for things that can be taken for it. Drawing the rest of the
// picture would take ten times as long.
constexpr int kSurroundingsPx = 80;

void keep_surroundings(PoseTrial* trial) {
  trial->scene.camera = cut_to_part(trial->scene.camera, trial->part, trial->truth(), kSurroundingsPx);
}

// A level for each of `count` trials, all equally often, in random order.
std::vector<std::size_t> balanced(std::size_t count, std::size_t levels, Dice* dice) {
  std::vector<std::size_t> drawn(count);
  for (std::size_t i = 0; i < count; ++i) drawn[i] = i % levels;
  for (std::size_t i = count; i > 1; --i) std::swap(drawn[i - 1], drawn[dice->index(i)]);
  return drawn;
}

double middle_hue_deg(const PartModel& part) {
  const double width = std::remainder(part.hue_hi_deg - part.hue_lo_deg, 360.0);
  return part.hue_lo_deg + width / 2;
}

Texture clouds(const LinearRgb& color, const LinearRgb& second, Dice* dice) {
  return {TextureKind::kNoise, color, second, dice->between(0.03, 0.2),
          static_cast<std::uint32_t>(dice->index(1 << 20))};
}

// Things of all colours behind the part, some as near to it in the picture as can be, one of its own hue beside it.
void add_clutter(Scene* scene, double hue_deg, Dice* dice) {
  const Eigen::Vector3d& center = scene->parts[0].cylinder.pose.center_in_cam;
  constexpr int kThings = 8;
  for (int i = 0; i < kThings; ++i) {
    const double farther = dice->between(1.4, 2);
    const double half = dice->between(0.02, 0.12) * farther;
    const bool own_hue = i == 0;
    // Farther out than the part and the thing are large.
    const double beside = own_hue ? 0.25 + 0.17 * farther + half : dice->between(0, 0.4);
    const double angle = dice->between(0, 2 * std::numbers::pi);
    Solid thing;
    thing.material.specular = dice->between(0, 0.2);
    thing.material.texture.color = linear_from_hsv(own_hue ? hue_deg : hue_deg + dice->between(60, 300),
                                                   dice->between(0.3, 0.95), dice->between(0.3, 0.9));
    const Eigen::Vector3d place =
        farther * (center + beside / farther * Eigen::Vector3d(std::cos(angle), std::sin(angle), 0));
    if (dice->index(2) == 0) {
      thing.shape = SphereSolid{place, half};
    } else {
      const Eigen::Matrix3d turned =
          Eigen::AngleAxisd(dice->between(0, 3), Eigen::Vector3d(1, dice->between(-1, 1), 0.5).normalized())
              .toRotationMatrix();
      thing.shape = BoxSolid{place, turned, {half, 0.6 * half, 0.3 * half}};
    }
    scene->others.push_back(thing);
  }
}

// Part, background and light; the part where `pose_of` puts it.
PoseTrial trial_of_kind(std::size_t kind, double distance_m, std::size_t tilt_level, std::uint64_t seed, Dice* dice) {
  RandomScene random = random_scene(seed);
  PoseTrial trial;
  trial.scenario = kKinds[kind];
  trial.part = random.part;
  trial.scene = std::move(random.scene);
  trial.scene.parts[0].cylinder.pose = random_pose(trial.scene.camera, trial.part, distance_m, kTiltLevels[tilt_level],
                                                   kTiltLevels[tilt_level + 1], dice);
  const double hue_deg = middle_hue_deg(trial.part);
  Texture& background = trial.scene.background;
  Lighting& light = trial.scene.lighting;
  const auto grey = [&](double low, double high) -> LinearRgb { return LinearRgb::Constant(dice->between(low, high)); };
  if (trial.scenario == "grey" || trial.scenario == "clutter") {
    background = clouds(grey(0.05, 0.2), grey(0.2, 0.7), dice);
  } else if (trial.scenario == "black sky") {
    background = {};
    background.color = LinearRgb::Zero();
    light.ambient = 0.1;
    light.key = 0.9;
  } else if (trial.scenario == "foil") {
    // Gold, away from the part's hue.
    background = clouds(linear_from_hsv(hue_deg + 180 + dice->between(-60, 60), 0.6, 0.5), LinearRgb::Ones(), dice);
    background.kind = TextureKind::kFoil;
    light.ambient = 0.1;
    light.key = 0.9;
  } else if (trial.scenario == "near hue") {
    const double away_deg = dice->between(35, 50) * (dice->index(2) == 0 ? 1 : -1);
    background = clouds(linear_from_hsv(hue_deg + away_deg, 0.5, dice->between(0.3, 0.5)),
                        linear_from_hsv(hue_deg + away_deg, 0.7, dice->between(0.5, 0.8)), dice);
  }
  if (trial.scenario == "clutter") add_clutter(&trial.scene, hue_deg, dice);
  const CylinderPose& pose = trial.truth();
  trial.tilt_deg = std::acos(std::min(1.0, std::abs(pose.axis_in_cam.dot(pose.center_in_cam.normalized())))) * 180 /
                   std::numbers::pi;
  return trial;
}

void hide(PoseTrial* trial, int percent, Dice* dice) {
  trial->occlusion_percent = percent;
  if (percent == 0) return;
  Solid bar;
  bar.shape = random_bar(trial->part, trial->truth(), percent / 100.0, dice);
  bar.material.texture.color = LinearRgb::Constant(dice->between(0.05, 0.6));
  trial->occluders.push_back(trial->scene.others.size());
  trial->scene.others.push_back(bar);
}

}  // namespace

std::vector<PoseTrial> random_trials(int count, std::uint64_t seed) {
  Dice dice(seed);
  const auto size = static_cast<std::size_t>(std::max(0, count));
  const auto kinds = balanced(size, kKinds.size(), &dice);
  const auto distances = balanced(size, kDistancesM.size(), &dice);
  const auto tilts = balanced(size, std::size(kTiltLevels) - 1, &dice);
  const auto occlusions = balanced(size, kOcclusions.size(), &dice);
  struct Other {
    const char* name;
    double noise;
    double blur_px;
  };
  constexpr std::array kOthers = {Other{"noise 0.5", 0.5, 0.6}, Other{"noise 3", 3, 0.6},  Other{"noise 6", 6, 0.6},
                                  Other{"blur 0.3", 1.5, 0.3},  Other{"blur 1", 1.5, 1.0}, Other{"blur 1.5", 1.5, 1.5}};
  const auto others = balanced(size, kOthers.size(), &dice);
  std::vector<PoseTrial> trials;
  for (std::size_t i = 0; i < size; ++i) {
    // Its own dice: a change to one trial leaves the others alone.
    Dice own(dice.bits());
    PoseTrial trial = trial_of_kind(kinds[i], kDistancesM[distances[i]], tilts[i], own.bits(), &own);
    trial.group = "random";
    trial.number = static_cast<int>(i);
    hide(&trial, kOcclusions[occlusions[i]], &own);
    if (trial.scenario != "clutter") keep_surroundings(&trial);
    DegradeOptions degrade;
    degrade.seed = own.bits();
    trial.pictures.push_back({kNominal, degrade, true});
    const Other& other = kOthers[others[i]];
    degrade.noise_sigma = other.noise;
    degrade.blur_sigma_px = other.blur_px;
    ++degrade.seed;
    trial.pictures.push_back({other.name, degrade});
    trials.push_back(std::move(trial));
  }
  return trials;
}

std::vector<PoseTrial> beyond_trials(int count, std::uint64_t seed) {
  Dice dice(seed);
  const auto size = static_cast<std::size_t>(std::max(0, count));
  const auto distances = balanced(size, kDistancesM.size(), &dice);
  constexpr std::size_t kKindsBeyond = 2;  // grey and coloured: what is at fault is the camera or the surface
  constexpr std::size_t kFirstTilt = 2;    // the sides are seen
  std::vector<PoseTrial> trials;
  for (std::size_t i = 0; i < size; ++i) {
    Dice own(dice.bits());
    const std::size_t tilt = kFirstTilt + own.index(std::size(kTiltLevels) - 1 - kFirstTilt);
    PoseTrial trial = trial_of_kind(i % kKindsBeyond, kDistancesM[distances[i]], tilt, own.bits(), &own);
    trial.group = "beyond";
    trial.number = static_cast<int>(i);
    DegradeOptions degrade;
    degrade.seed = own.bits();
    const auto add = [&](const char* variant, const auto& change) {
      DegradeOptions changed = degrade;
      change(changed);
      trial.pictures.push_back({variant, changed});
    };
    Material& material = trial.scene.parts[0].material;
    switch (i % 9) {  // the light is another one: no picture in common with the rest
      case 2:
        material.roughness_rad = 0.6;
        material.specular = 0;
        add("rough surface", [](DegradeOptions&) {});
        break;
      case 5:
        material.specular = 0.6;
        material.exponent = 60;
        add("glossy surface", [](DegradeOptions&) {});
        break;
      case 7:
        material.refractive_index = 1.5;
        add("varnished surface", [](DegradeOptions&) {});
        break;
      case 8:
        trial.scene.lighting.ambient = 0.02;
        trial.scene.lighting.key = 1.3;
        add("hard light", [](DegradeOptions&) {});
        break;
      default:
        add(kNominal, [](DegradeOptions&) {});
        add("box blur", [](DegradeOptions& d) { d.effects.blur = BlurKernel::kBox; });
        add("motion blur 1.5", [](DegradeOptions& d) {
          d.effects.blur = BlurKernel::kMotion;
          d.blur_sigma_px = 1.5;
        });
        add("defocus 3", [](DegradeOptions& d) { d.blur_sigma_px = 3; });
        add("shot noise 3", [](DegradeOptions& d) {
          d.effects.noise = NoiseKind::kShot;
          d.noise_sigma = 3;
        });
        add("speckle 3", [](DegradeOptions& d) {
          d.effects.noise = NoiseKind::kSpeckle;
          d.noise_sigma = 3;
        });
        add("gamma 2.2", [](DegradeOptions& d) { d.effects.gamma_2_2 = true; });
        add("vignetting 0.5", [](DegradeOptions& d) { d.effects.vignetting = 0.5; });
        add("sharpened 1", [](DegradeOptions& d) { d.effects.sharpening = 1; });
        add("chroma 4:2:0", [](DegradeOptions& d) { d.effects.chroma_420 = true; });
    }
    trials.push_back(std::move(trial));
  }
  return trials;
}

std::vector<PoseTrial> scenario_trials(std::string_view name, int count, std::uint64_t seed) {
  const Scenario& scenario = find_scenario(name);
  const int frames = std::max(0, count);
  std::vector<PoseTrial> trials;
  for (int frame = 0; frame < frames; ++frame) {
    PoseTrial trial;
    trial.group = "scenario";
    trial.scenario = scenario.name;
    trial.number = frame;
    trial.scene = scenario.scene(frame, frames);
    trial.part = scenario.parts.at(0);
    const CylinderPose& pose = trial.truth();
    trial.tilt_deg = std::acos(std::min(1.0, std::abs(pose.axis_in_cam.dot(pose.center_in_cam.normalized())))) * 180 /
                     std::numbers::pi;
    // Arm and bar hide ends of the part; nothing does so elsewhere.
    trial.has_bound = scenario.name.starts_with("series") || scenario.name == "candle";
    if (trial.has_bound) keep_surroundings(&trial);
    DegradeOptions degrade;
    degrade.blur_sigma_px = scenario.blur_sigma_px;
    degrade.noise_sigma = scenario.noise_sigma;
    degrade.transfer = scenario.camera.transfer;
    degrade.seed = seed + static_cast<std::uint64_t>(frame);
    trial.pictures.push_back({kNominal, degrade, true});
    trials.push_back(std::move(trial));
  }
  return trials;
}

}  // namespace cylpose::bench
