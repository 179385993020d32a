#include "plots.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cylpose/image_cv.hpp>
#include <cylpose/overlay.hpp>
#include <iterator>
#include <numbers>
#include <opencv2/imgproc.hpp>

#include "chart.hpp"
#include "consistency.hpp"

namespace cylpose::bench {
namespace {

Chart location_chart(const std::string& factor, std::span<const Location> locations) {
  Chart chart{"edge location over " + factor, {factor, 0, 1, false, {}}, {"px", 0.001, 1, true, {}}, {}};
  Series bias{"mean |bias|", Mark::kBars, 6, {}};
  Series scatter{"sigma", Mark::kDots, 1, {}};
  Series bound{"Cramer-Rao bound", Mark::kLine, 2, {}};
  for (const Location& location : locations) {
    if (location.factor != factor) continue;
    const double x = static_cast<double>(chart.x.categories.size()) + 0.5;
    chart.x.categories.push_back(location.level);
    bias.points.emplace_back(x, location.mean_abs_bias_px);
    scatter.points.emplace_back(x, location.sigma_px);
    bound.points.emplace_back(x, location.bound_px);
  }
  chart.x.high = static_cast<double>(chart.x.categories.size());
  chart.series = {bias, scatter, bound};
  return chart;
}

// Among the frames of `series1`, which comes nearer step by step, and the random scenes beside it.
Chart distance_chart(std::span<const Outcome> outcomes) {
  Chart chart{"centre error over distance (dots: random scenes, nothing hidden, tilt 30 deg and more)",
              {"m", 0.8, 6, true, {}},
              {"mm", 0.003, 1000, true, {}},
              {}};
  Series thesis{"thesis, series1", Mark::kLine, 4, {}};
  Series ours{"default, series1", Mark::kLine, 0, {}};
  Series bound{"Cramer-Rao bound, series1", Mark::kDashes, 2, {}};
  Series random_thesis{"thesis", Mark::kDots, 4, {}};
  Series random_ours{"default", Mark::kDots, 0, {}};
  for (const Outcome& o : outcomes) {
    if (!o.found || o.variant != kNominal) continue;
    const bool by_thesis = o.method == "thesis";
    const cv::Point2d point(o.distance_m, 1000 * o.error.position_m);
    if (o.scenario == "series1") {
      (by_thesis ? thesis : ours).points.push_back(point);
      if (!by_thesis && o.bound) bound.points.emplace_back(o.distance_m, 1000 * o.bound->center_m);
    } else if (o.group == "random" && o.occlusion_percent == 0 && o.tilt_deg >= 30) {
      // Beside each other: the distances are few.
      const double jitter = 1 + 0.004 * (o.trial % 11) + (by_thesis ? 0.06 : 0);
      (by_thesis ? random_thesis : random_ours).points.emplace_back(jitter * point.x, point.y);
    }
  }
  for (Series* series : {&thesis, &ours, &bound}) {
    std::ranges::sort(series->points, {}, [](const cv::Point2d& p) { return p.x; });
  }
  chart.series = {random_thesis, random_ours, thesis, ours, bound};
  return chart;
}

Chart nees_chart(std::span<const Outcome> outcomes) {
  constexpr double kWidth = 1;
  constexpr int kBins = 26;
  std::vector<double> counts(kBins, 0.0);
  int all = 0;
  double sum = 0;
  for (const Outcome& o : outcomes) {
    if (o.group != "random" || o.variant != kNominal || !o.nees) continue;
    ++all;
    sum += *o.nees;
    counts[static_cast<std::size_t>(std::min(kBins - 1.0, *o.nees / kWidth))] += 1;
  }
  const std::string mean = all > 0 ? fmt::format("mean {:.3g}, 95 % band of it [{:.2f}, {:.2f}]", sum / all,
                                                 mean_nees_band(all).low, mean_nees_band(all).high)
                                   : "no pose";
  Chart chart{"NEES of " + std::to_string(all) + " random scenes; " + mean,
              {"5 degrees of freedom; the last bar holds all above", 0, kBins * kWidth, false, {}},
              {"share", 0, 0.25, false, {}},
              {}};
  Series bars{"found", Mark::kBars, 6, {}};
  Series density{"chi-squared", Mark::kLine, 2, {}};
  for (int i = 0; i < kBins; ++i) {
    bars.points.emplace_back((i + 0.5) * kWidth, counts[static_cast<std::size_t>(i)] / std::max(1, all));
  }
  for (double x = 0; x <= kBins * kWidth; x += 0.2) {
    // x^(3/2) e^(-x/2) / (2^(5/2) Gamma(5/2))
    density.points.emplace_back(x,
                                kWidth * std::pow(x, 1.5) * std::exp(-x / 2) / (std::pow(2, 2.5) * std::tgamma(2.5)));
  }
  Series limits{"95 % of single frames", Mark::kDashes, 1, {}};
  const double high = chi_squared_quantile(0.95, kDegreesOfFreedom);
  limits.points = {{high, 0}, {high, 0.25}};
  chart.series = {bars, density, limits};
  return chart;
}

}  // namespace

cv::Mat location_plot(std::span<const Location> locations) {
  std::vector<std::string> factors;
  for (const Location& location : locations) {
    if (location.factor != kUsual && std::ranges::find(factors, location.factor) == factors.end()) {
      factors.push_back(location.factor);
    }
  }
  std::vector<Chart> charts;
  charts.reserve(factors.size());
  for (const std::string& factor : factors) charts.push_back(location_chart(factor, locations));
  return drawn(charts, 3, {640, 330});
}

cv::Mat pose_plot(std::span<const Outcome> outcomes) {
  return drawn({distance_chart(outcomes), nees_chart(outcomes)}, 2);
}

std::vector<const Outcome*> worst(std::span<const Outcome> outcomes, std::size_t count) {
  std::vector<const Outcome*> found;
  for (const Outcome& o : outcomes) {
    if (o.found && o.method != "thesis") found.push_back(&o);
  }
  const auto badness = [](const Outcome* o) {
    const double ratio = o->bound ? o->error.position_m / o->bound->center_m : 0;
    return std::pair(o->wrong, ratio);
  };
  const std::size_t kept = std::min(count, found.size());
  std::ranges::partial_sort(found, found.begin() + static_cast<std::ptrdiff_t>(kept), std::ranges::greater{}, badness);
  found.resize(kept);
  return found;
}

cv::Mat picture_of(const Outcome& outcome, std::span<const PoseTrial> trials) {
  const auto trial = std::ranges::find_if(trials, [&](const PoseTrial& t) {
    return t.group == outcome.group && t.number == outcome.trial &&
           (t.group != "scenario" || t.scenario == outcome.scenario);
  });
  const auto picture =
      std::ranges::find(trial->pictures, outcome.variant, [](const PictureOfTrial& p) { return p.variant; });
  const cv::Mat image = picture_of(*trial, *picture);
  const auto estimator = usual_methods().front().make(trial->scene.camera, trial->part);
  const FrameEstimate estimate = estimator->estimate(view_of(image));
  cv::Mat drawing = overlay(image, trial->scene.camera, {&trial->part, 1}, estimate);
  std::vector<cv::Point> outline;
  constexpr int kShift = 4;  // sixteenths of a pixel
  for (const Eigen::Vector2d& ray : silhouette(trial->truth(), trial->part.radius_m, trial->part.height_m)) {
    const Eigen::Vector2d pixel = project(trial->scene.camera, {ray.x(), ray.y(), 1}) * (1 << kShift);
    outline.emplace_back(static_cast<int>(std::lround(pixel.x())), static_cast<int>(std::lround(pixel.y())));
  }
  cv::polylines(drawing, outline, true, {0, 255, 0}, 1, cv::LINE_AA, kShift);
  const std::string words = fmt::format(
      "{} {} {}, {}: {:.2f} m, tilt {:.0f} deg, {} % hidden; off by {:.1f} mm and {:.2f} deg{}", outcome.group,
      outcome.scenario, outcome.trial, outcome.variant, outcome.distance_m, outcome.tilt_deg, outcome.occlusion_percent,
      1000 * outcome.error.position_m, outcome.error.axis_angle_deg, outcome.wrong ? ", WRONG" : "");
  cv::putText(drawing, words, {12, drawing.rows - 14}, cv::FONT_HERSHEY_SIMPLEX, 0.6, {0, 0, 0}, 4, cv::LINE_AA);
  cv::putText(drawing, words, {12, drawing.rows - 14}, cv::FONT_HERSHEY_SIMPLEX, 0.6, {0, 255, 0}, 1, cv::LINE_AA);
  return drawing;
}

}  // namespace cylpose::bench
