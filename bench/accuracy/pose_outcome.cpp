#include "pose_outcome.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cylpose/backend.hpp>
#include <cylpose/contour.hpp>
#include <cylpose/image_cv.hpp>
#include <exception>
#include <mutex>
#include <numbers>
#include <thread>
#include <utility>

#include "bound.hpp"
#include "consistency.hpp"
#include "random_place.hpp"

namespace cylpose::bench {
namespace {

// The bounds of one picture: with its edges as they are, and generous.
struct Bounds {
  std::optional<PieceSigmas> scatter;
  std::optional<Matrix5d> covariance;
  std::optional<Matrix5d> generous;
};

Bounds bounds_of(const PoseTrial& trial, const std::vector<ContourSample>& samples, const DegradeOptions& degrade,
                 const ImageView& image) {
  const CameraModel& camera = trial.scene.camera;
  const auto outline = Outline::of(camera, trial.part, trial.truth());
  if (!trial.has_bound || !outline) return {};
  DetectOptions options;
  options.transfer = degrade.transfer;
  const EdgeField field = make_backend("serial")->detect(image, image.bounds(), {&trial.part, 1}, options);
  Bounds bounds;
  bounds.scatter = edge_scatter(*outline, edge_points(camera, with_hysteresis(field.parts[0].edges)));
  if (!bounds.scatter) return bounds;
  PieceSigmas generous{};
  std::transform(bounds.scatter->begin(), bounds.scatter->end(), generous.begin(),
                 [](double sigma) { return std::max(kGenerousFloorPx, kGenerousFactor * sigma); });
  bounds.covariance = pose_bound(camera, trial.part, trial.truth(), samples, *bounds.scatter);
  bounds.generous = pose_bound(camera, trial.part, trial.truth(), samples, generous);
  return bounds;
}

double root_mean(const PieceSigmas& sigmas) {
  double sum = 0;
  for (const double sigma : sigmas) sum += sigma * sigma;
  return std::sqrt(sum / kOutlinePieces);
}

double depth_sigma(const Eigen::Matrix3d& of_center, const Eigen::Vector3d& sight) {
  return std::sqrt(sight.dot(of_center * sight));
}

SceneBound in_words(const Matrix5d& bound, const Eigen::Vector3d& sight) {
  return {std::sqrt(bound.topLeftCorner<3, 3>().trace()), depth_sigma(bound.topLeftCorner<3, 3>(), sight),
          std::sqrt(bound.bottomRightCorner<2, 2>().trace()) * 180 / std::numbers::pi};
}

void judge(const PoseEstimate& estimate, const Bounds& bounds, Outcome* outcome) {
  outcome->found = estimate.status == PoseStatus::kOk;
  outcome->reason = estimate.reason;
  const Eigen::Vector3d sight = outcome->truth.center_in_cam.normalized();
  if (bounds.covariance) outcome->bound = in_words(*bounds.covariance, sight);
  if (bounds.scatter) outcome->edge_sigma_px = root_mean(*bounds.scatter);
  if (!outcome->found) return;
  outcome->pose = estimate.pose;
  outcome->error = pose_error(estimate.pose, outcome->truth);
  outcome->depth_error_m = sight.dot(estimate.pose.center_in_cam - outcome->truth.center_in_cam);
  outcome->rms_px = estimate.rms_px;
  outcome->seen = estimate.seen;
  std::optional<double> sigmas;
  if (bounds.generous) sigmas = mahalanobis(difference(outcome->truth, estimate.pose), *bounds.generous);
  outcome->wrong = is_wrong(outcome->error, outcome->distance_m, sigmas);
}

Outcome described(const PoseTrial& trial, const PictureOfTrial& picture, const Method& method) {
  Outcome outcome;
  outcome.group = trial.group;
  outcome.scenario = trial.scenario;
  outcome.variant = picture.variant;
  outcome.method = method.name;
  outcome.trial = trial.number;
  outcome.distance_m = trial.distance_m();
  outcome.tilt_deg = trial.tilt_deg;
  outcome.occlusion_percent = trial.occlusion_percent;
  outcome.noise_sigma = picture.degrade.noise_sigma;
  outcome.blur_sigma_px = picture.degrade.blur_sigma_px;
  outcome.truth = trial.truth();
  return outcome;
}

std::vector<ContourSample> seen_contour(const PoseTrial& trial) {
  const CameraModel& camera = trial.scene.camera;
  return contour_samples(camera, trial.part, trial.truth(), [&](const Eigen::Vector2d& position) {
    return std::ranges::none_of(trial.occluders, [&](std::size_t i) {
      return hides(camera, std::get<BoxSolid>(trial.scene.others[i].shape), position);
    });
  });
}

}  // namespace

std::vector<Method> usual_methods() {
  return {{"default", false,
           [](const CameraModel& camera, const PartModel& part) {
             return make_estimator(camera, {part}, make_backend("serial"));
           }},
          {"thesis", true,
           [](const CameraModel& camera, const PartModel& part) { return make_estimator("thesis", camera, {part}); }}};
}

cv::Mat picture_of(const PoseTrial& trial, const PictureOfTrial& picture) {
  return degrade(render(trial.scene), picture.degrade);
}

std::vector<Outcome> outcomes_of(const PoseTrial& trial, std::span<const Method> methods) {
  const SceneLight light = render(trial.scene);
  const std::vector<ContourSample> contour = seen_contour(trial);
  std::vector<Outcome> outcomes;
  for (const PictureOfTrial& picture : trial.pictures) {
    const cv::Mat image = degrade(light, picture.degrade);
    const Bounds bounds = bounds_of(trial, contour, picture.degrade, view_of(image));
    for (const Method& method : methods) {
      if (method.thesis && !picture.by_thesis) continue;
      Outcome outcome = described(trial, picture, method);
      const FrameEstimate frame = method.make(trial.scene.camera, trial.part)->estimate(view_of(image));
      const PoseEstimate& estimate = frame.parts.at(0);
      judge(estimate, bounds, &outcome);
      if (outcome.found && !method.thesis) {
        outcome.nees = nees(estimate, trial.truth());
        outcome.sigma_depth_m =
            depth_sigma(estimate.covariance.topLeftCorner<3, 3>(), trial.truth().center_in_cam.normalized());
      }
      outcomes.push_back(std::move(outcome));
    }
  }
  return outcomes;
}

std::vector<Outcome> run_trials(std::span<const PoseTrial> trials, std::span<const Method> methods, int threads,
                                const std::function<void(std::size_t)>& progress) {
  std::vector<std::vector<Outcome>> of_trial(trials.size());
  std::atomic<std::size_t> next{0};
  std::mutex mutex;
  std::size_t done = 0;
  std::exception_ptr failure;
  const auto work = [&] {
    for (std::size_t i = next++; i < trials.size(); i = next++) {
      try {
        of_trial[i] = outcomes_of(trials[i], methods);
      } catch (...) {
        const std::lock_guard lock(mutex);
        failure = std::current_exception();
        next = trials.size();
        return;
      }
      const std::lock_guard lock(mutex);
      progress(++done);
    }
  };
  {
    std::vector<std::jthread> workers;
    for (int i = 1; i < threads; ++i) workers.emplace_back(work);
    work();
  }
  if (failure) std::rethrow_exception(failure);
  std::vector<Outcome> all;
  for (auto& outcomes : of_trial) std::move(outcomes.begin(), outcomes.end(), std::back_inserter(all));
  return all;
}

}  // namespace cylpose::bench
