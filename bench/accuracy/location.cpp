#include "location.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cylpose/backend.hpp>
#include <cylpose/error.hpp>
#include <cylpose/image_cv.hpp>
#include <cylpose/render.hpp>
#include <cylpose/srgb.hpp>
#include <numeric>
#include <opencv2/core.hpp>
#include <set>
#include <utility>

#include "angle.hpp"

namespace cylpose::bench {
namespace {

using testing::light_of_codes;
using testing::SlantedEdge;
using testing::SlantedEdgePicture;

const PartModel kRed{"red", 0.05, 0.4, 340, 20, 0.3, 0.1};
constexpr int kRim = 12;           // pixels at the picture's own edges that do not count
constexpr double kNearPx = 4;      // edges farther from the border are specks of noise
constexpr int kFewestPoints = 20;  // of one orientation and phase

SlantedEdge usual_edge() {
  SlantedEdge edge;
  edge.part = light_of_codes(200, 40, 40);
  edge.background = light_of_codes(140, 140, 140);
  edge.noise = 2;
  edge.blur_px = 0.8;
  return edge;
}

DegradeOptions degrade_of(const LocationCase& location_case) {
  DegradeOptions degrade;
  degrade.blur_sigma_px = 0;  // the picture has its own
  degrade.noise_sigma = location_case.edge.noise;
  degrade.transfer = location_case.edge.linear_codes ? Transfer::kLinear : Transfer::kSrgb;
  degrade.seed = location_case.edge.seed;
  degrade.effects.noise = location_case.noise_kind;
  degrade.effects.gamma_2_2 = location_case.gamma_2_2;
  degrade.effects.sharpening = location_case.sharpening;
  degrade.effects.chroma_420 = location_case.chroma_420;
  return degrade;
}

cv::Mat picture_of(const LocationCase& location_case) {
  const SlantedEdgePicture picture(location_case.edge);
  cv::Mat light(location_case.edge.size, location_case.edge.size, CV_32FC3);
  for (int y = 0; y < light.rows; ++y) {
    for (int x = 0; x < light.cols; ++x) {
      const testing::Rgb rgb = picture.light(x, y);
      light.at<cv::Vec3f>(y, x) = cv::Vec3d(rgb[2], rgb[1], rgb[0]);
    }
  }
  return degrade(light, degrade_of(location_case));
}

struct Errors {
  std::vector<double> px;  // signed distances of the located strong edge pixels from the border
  std::size_t lines = 0;   // rows of pixels that they come from; columns where those are nearer to the normal
};

Errors errors_of(const LocationCase& location_case) {
  const SlantedEdge& edge = location_case.edge;
  const cv::Mat picture = picture_of(location_case);
  DetectOptions options;
  options.transfer = degrade_of(location_case).transfer;
  const ImageView image = view_of(picture);
  const EdgeField field = make_backend("serial")->detect(image, image.bounds(), {&kRed, 1}, options);
  const bool along_row = std::abs(std::cos(edge.angle_rad)) >= std::abs(std::sin(edge.angle_rad));
  Errors errors;
  std::set<int> lines;
  for (const EdgePixel& pixel : field.parts.at(0).edges) {
    const bool at_rim = pixel.x < kRim || pixel.y < kRim || pixel.x >= edge.size - kRim || pixel.y >= edge.size - kRim;
    if (at_rim || pixel.strength != EdgeStrength::kStrong || std::abs(edge.inside(pixel.x, pixel.y)) > kNearPx)
      continue;
    const auto [x, y] = testing::located(pixel);
    errors.px.push_back(edge.inside(x, y));
    lines.insert(along_row ? pixel.y : pixel.x);
  }
  errors.lines = lines.size();
  if (errors.px.size() < kFewestPoints) {
    throw Error(ErrorKind::kInput,
                fmt::format("location, {} {}: only {} edge pixels at {:.0f} deg; the border is too faint to measure",
                            location_case.factor, location_case.level, errors.px.size(), edge.angle_rad / radians(1)));
  }
  return errors;
}

double mean_of(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

double code_of(const LocationCase& location_case, double light) {
  const double cut = std::clamp(light, 0.0, 1.0);
  if (location_case.gamma_2_2) return 255 * std::pow(cut, 1 / 2.2);
  return 255 * (location_case.edge.linear_codes ? cut : srgb_from_linear(cut));
}

void vary(std::vector<LocationCase>* cases, const char* factor, const std::string& level,
          const std::function<void(LocationCase&)>& change) {
  LocationCase one{factor, level, usual_edge(), true, NoiseKind::kGaussian, false, 0, false, {}, {}};
  change(one);
  cases->push_back(std::move(one));
}

}  // namespace

std::vector<LocationCase> location_cases() {
  std::vector<LocationCase> cases;
  const auto add = [&](const char* factor, const std::string& level, const auto& change) {
    vary(&cases, factor, level, change);
  };
  const auto number = [](double value) { return fmt::format("{:g}", value); };
  add("usual", kUsual, [](LocationCase&) {});
  for (const double contrast : {25, 50, 100, 150, 200}) {
    add("contrast", number(contrast),
        [=](LocationCase& c) { c.edge.background = light_of_codes(40 + contrast, 40 + contrast, 40 + contrast); });
  }
  for (const double blur : {0.3, 0.5, 0.8, 1.0, 1.5, 2.0}) {
    add("blur", number(blur), [=](LocationCase& c) { c.edge.blur_px = blur; });
  }
  for (const double noise : {0.5, 1.0, 2.0, 4.0, 8.0}) {
    add("noise", number(noise), [=](LocationCase& c) { c.edge.noise = noise; });
  }
  for (const double angle : {0, 10, 20, 30, 40, 45, 60, 75, 90}) {
    add("orientation", number(angle), [=](LocationCase& c) { c.angles_deg = {angle, angle + 180}; });
  }
  for (const double phase : {-0.4, -0.2, 0.0, 0.2, 0.4}) {
    add("phase", number(phase), [=](LocationCase& c) { c.phases_px = {phase, phase, phase}; });
  }
  add("shading", "none", [](LocationCase& c) { c.edge.limb_px = 0; });
  for (const double limb : {10, 40, 160}) {
    add("shading", fmt::format("limb {} px", limb), [=](LocationCase& c) { c.edge.limb_px = limb; });
  }
  add("shading", "no ambient", [](LocationCase& c) { c.edge.ambient = 0.02; });
  const auto background = [&](const char* name, double r, double g, double b, bool null_channel) {
    add("background", name, [=](LocationCase& c) {
      c.edge.background = light_of_codes(r, g, b);
      c.null_channel = null_channel;
    });
  };
  background("grey", 140, 140, 140, true);
  background("white", 255, 255, 255, true);
  background("blue", 40, 60, 160, true);
  background("green", 60, 150, 60, true);
  background("brown", 120, 80, 50, true);
  background("near hue", 140, 100, 40, true);  // orange: light in green that the part has not
  background("black", 2, 2, 2, false);
  // Shading is all that matters before black: how wide the part is, and where its light comes from.
  const auto before_black = [&](const std::string& level, const auto& change) {
    add("before black", level, [=](LocationCase& c) {
      c.edge.background = light_of_codes(2, 2, 2);
      c.null_channel = false;
      change(c);
    });
  };
  before_black("evenly lit", [](LocationCase& c) { c.edge.limb_px = 0; });
  before_black("limb 10 px", [](LocationCase& c) { c.edge.limb_px = 10; });
  before_black("limb 160 px", [](LocationCase& c) { c.edge.limb_px = 160; });
  before_black("no ambient", [](LocationCase& c) { c.edge.ambient = 0.02; });
  before_black("lit from aside", [](LocationCase& c) { c.edge.light_rad = radians(60); });
  before_black("lit from behind", [](LocationCase& c) { c.edge.light_rad = radians(-20); });
  before_black("blur 1.5", [](LocationCase& c) { c.edge.blur_px = 1.5; });
  before_black("blur 0.4", [](LocationCase& c) { c.edge.blur_px = 0.4; });
  before_black("noise 4", [](LocationCase& c) { c.edge.noise = 4; });
  add("background", "textured", [](LocationCase& c) {
    c.edge.background = light_of_codes(90, 90, 90);
    c.edge.second = light_of_codes(180, 180, 180);
    c.edge.texture_px = 20;
  });
  add("background", "fine texture", [](LocationCase& c) {
    c.edge.background = light_of_codes(90, 90, 90);
    c.edge.second = light_of_codes(180, 180, 180);
    c.edge.texture_px = 7;
  });
  add("transfer", "sRGB", [](LocationCase&) {});
  add("transfer", "linear", [](LocationCase& c) {
    c.edge.linear_codes = true;
    c.edge.part = {200 / 255.0, 40 / 255.0, 40 / 255.0};
    c.edge.background = {140 / 255.0, 140 / 255.0, 140 / 255.0};
  });
  add("transfer", "gamma 2.2", [](LocationCase& c) { c.gamma_2_2 = true; });
  add("camera", "box blur", [](LocationCase& c) {
    c.edge.blur_px = 0.4;
    c.edge.box_px = 2;
  });
  add("camera", "shot noise", [](LocationCase& c) { c.noise_kind = NoiseKind::kShot; });
  add("camera", "chroma 4:2:0", [](LocationCase& c) { c.chroma_420 = true; });
  add("camera", "sharpened 0.5", [](LocationCase& c) { c.sharpening = 0.5; });
  add("camera", "sharpened 1", [](LocationCase& c) { c.sharpening = 1; });
  return cases;
}

double edge_bound(const LocationCase& location_case, double angle_deg) {
  LocationCase turned = location_case;
  turned.edge.angle_rad = radians(angle_deg);
  const SlantedEdgePicture picture(turned.edge);
  constexpr double kStep = 1.0 / 64;
  constexpr double kReach = 6;
  double information = 0;  // per pixel of length along the border, over sigma^2
  for (double depth = -kReach; depth < kReach; depth += kStep) {
    const testing::Rgb before = picture.light_at(depth);
    const testing::Rgb after = picture.light_at(depth + kStep);
    for (std::size_t c = 0; c < 3; ++c) {
      const double slope = (code_of(turned, after[c]) - code_of(turned, before[c])) / kStep;
      information += slope * slope * kStep;
    }
  }
  // A row has one pixel in each 1 / |cosine| of the border's length, or a column.
  const double length =
      1 / std::max(std::abs(std::cos(turned.edge.angle_rad)), std::abs(std::sin(turned.edge.angle_rad)));
  const double variance = turned.edge.noise * turned.edge.noise + 1.0 / 12;
  return std::sqrt(variance / (information * length));
}

Location measured(const LocationCase& location_case, bool fine) {
  std::vector<double> angles = location_case.angles_deg;
  for (int angle = 5; angles.empty() || (location_case.angles_deg.empty() && angle < 360); angle += fine ? 30 : 97) {
    angles.push_back(angle);
  }
  std::vector<double> phases = location_case.phases_px;
  if (phases.empty()) phases = fine ? std::vector{-0.4, -0.2, 0.0, 0.2, 0.4} : std::vector{-0.3, 0.0, 0.3};

  Location location{location_case.factor, location_case.level, location_case.null_channel};
  LocationCase one = location_case;
  double bound_squares = 0;
  double squares = 0;
  double squares_of_means = 0;
  double sum = 0;
  for (const double angle : angles) {
    one.edge.angle_rad = radians(angle);
    std::vector<double> errors;
    std::vector<std::pair<double, double>> pictures;  // lines and mean error
    for (const double phase : phases) {
      one.edge.phase = phase;
      ++one.edge.seed;
      const Errors more = errors_of(one);
      errors.insert(errors.end(), more.px.begin(), more.px.end());
      pictures.emplace_back(more.lines, mean_of(more.px));
    }
    const double mean = mean_of(errors);
    for (const auto& [lines, of_picture] : pictures) squares_of_means += lines * std::pow(of_picture - mean, 2);
    for (const double error : errors) squares += (error - mean) * (error - mean);
    sum += mean * static_cast<double>(errors.size());
    location.points += static_cast<int>(errors.size());
    location.mean_abs_bias_px += std::abs(mean) / static_cast<double>(angles.size());
    location.worst_bias_px = std::max(location.worst_bias_px, std::abs(mean));
    const double bound = edge_bound(one, angle);
    bound_squares += bound * bound / static_cast<double>(angles.size());
  }
  location.bias_px = sum / location.points;
  location.sigma_px = std::sqrt(squares / location.points);
  const std::size_t freedom = angles.size() * std::max<std::size_t>(phases.size() - 1, 1);
  location.pooled_px = std::sqrt(squares_of_means / static_cast<double>(freedom));
  location.bound_px = std::sqrt(bound_squares);
  return location;
}

std::string text_of(std::span<const Location> locations) {
  std::string text =
      fmt::format("{:<14}{:<18}{:>6}{:>10}{:>10}{:>10}{:>10}{:>10}{:>8}{:>10}{:>8}{:>8}\n", "location [px]", "", "null",
                  "bias", "mean |b|", "worst", "sigma", "bound", "ratio", "pooled", "ratio", "points");
  for (const Location& l : locations) {
    text +=
        fmt::format("{:<14}{:<18}{:>6}{:>+10.4f}{:>10.4f}{:>10.4f}{:>10.4f}{:>10.4f}{:>8.2f}{:>10.4f}{:>8.2f}{:>8}\n",
                    l.factor, l.level, l.null_channel ? "yes" : "no", l.bias_px, l.mean_abs_bias_px, l.worst_bias_px,
                    l.sigma_px, l.bound_px, l.sigma_px / l.bound_px, l.pooled_px, l.pooled_px / l.bound_px, l.points);
  }
  return text;
}

std::string csv_of(std::span<const Location> locations) {
  std::string csv =
      "factor,level,null_channel,bias_px,mean_abs_bias_px,worst_bias_px,sigma_px,pooled_px,bound_px,points\n";
  for (const Location& l : locations) {
    csv += fmt::format("{},\"{}\",{},{:.6g},{:.6g},{:.6g},{:.6g},{:.6g},{:.6g},{}\n", l.factor, l.level,
                       l.null_channel ? 1 : 0, l.bias_px, l.mean_abs_bias_px, l.worst_bias_px, l.sigma_px, l.pooled_px,
                       l.bound_px, l.points);
  }
  return csv;
}

}  // namespace cylpose::bench
