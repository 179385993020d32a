// What came of one picture of a trial by one method.
#pragma once

#include <Eigen/Core>
#include <cylpose/cylinder.hpp>
#include <cylpose/estimator.hpp>
#include <cylpose/evaluate.hpp>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "pose_trial.hpp"
#include "verdict.hpp"

namespace cylpose::bench {

/// Standard deviations at the Cramer-Rao bound of the scene, with the scatter that its located edges have.
struct SceneBound {
  double center_m;  ///< root of the sum of the three variances
  double depth_m;   ///< along the line of sight
  double axis_deg;  ///< root of the sum of the two variances
};

struct Outcome {
  std::string group, scenario, variant, method;
  int trial = 0;
  double distance_m = 0;
  double tilt_deg = 0;
  int occlusion_percent = 0;
  double noise_sigma = 0;
  double blur_sigma_px = 0;

  bool found = false;
  std::string reason;  ///< where not found
  CylinderPose truth;
  CylinderPose pose;           ///< where found, as the following
  PoseError error;             ///< of the pose
  double depth_error_m = 0;    ///< signed, along the line of sight; positive: estimated too far away
  std::optional<double> nees;  ///< where the method states a covariance
  double sigma_depth_m = 0;    ///< as stated
  double rms_px = 0;
  double seen = 0;
  bool wrong = false;
  std::optional<SceneBound> bound;
  double edge_sigma_px = 0;  ///< scatter of the located edges about the true outline; 0 where too few were found
};

struct Method {
  std::string name;
  bool thesis;  ///< only for pictures that ask for it; states no covariance worth testing
  std::function<std::unique_ptr<Estimator>(const CameraModel&, const PartModel&)> make;
};

/// The default method on the serial backend, which all others equal, and the thesis's.
[[nodiscard]] std::vector<Method> usual_methods();

/// Renders a trial once and estimates all its pictures, each as the first one of a stream.
[[nodiscard]] std::vector<Outcome> outcomes_of(const PoseTrial& trial, std::span<const Method> methods);

/// All trials on `threads` threads; outcomes in the order of the trials. `progress` is called with the number of trials
/// done, from one thread at a time. Throws what a trial throws.
[[nodiscard]] std::vector<Outcome> run_trials(std::span<const PoseTrial> trials, std::span<const Method> methods,
                                              int threads, const std::function<void(std::size_t)>& progress);

/// The picture of a trial, as the methods see it.
[[nodiscard]] cv::Mat picture_of(const PoseTrial& trial, const PictureOfTrial& picture);

}  // namespace cylpose::bench
