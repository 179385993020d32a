// The accuracy bench judges an estimator: a good one, and ones with deliberate faults that it has to report.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cylpose/backend.hpp>
#include <cylpose/error.hpp>
#include <functional>
#include <map>
#include <memory>
#include <utility>

#include "bound.hpp"
#include "plots.hpp"
#include "pose_outcome.hpp"
#include "pose_summary.hpp"
#include "random_place.hpp"
#include "requirements.hpp"

namespace cylpose::bench {
namespace {

using ::testing::HasSubstr;

// The default method, its poses changed.
class Faulty final : public Estimator {
 public:
  Faulty(std::unique_ptr<Estimator> honest, std::function<void(PoseEstimate&)> fault)
      : honest_(std::move(honest)), fault_(std::move(fault)) {}

  [[nodiscard]] std::string_view name() const override { return "faulty"; }
  [[nodiscard]] FrameEstimate estimate(const ImageView& image, StageTrace* trace) override {
    FrameEstimate frame = honest_->estimate(image, trace);
    for (PoseEstimate& part : frame.parts) {
      if (part.status == PoseStatus::kOk) fault_(part);
    }
    return frame;
  }
  void reset() override { honest_->reset(); }

 private:
  std::unique_ptr<Estimator> honest_;
  std::function<void(PoseEstimate&)> fault_;
};

Method method_with(std::function<void(PoseEstimate&)> fault) {
  return {"faulty", false, [=](const CameraModel& camera, const PartModel& part) -> std::unique_ptr<Estimator> {
            return std::make_unique<Faulty>(make_estimator(camera, {part}, make_backend("serial")), fault);
          }};
}

// A few scenes before even grey, one picture each: small and without surprises.
std::vector<PoseTrial> easy_trials() {
  std::vector<PoseTrial> trials = scenario_trials("series3", 8, 1);
  for (PoseTrial& trial : trials) {
    trial.group = "random";
    trial.pictures.resize(1);
    trial.pictures[0].by_thesis = false;
  }
  return trials;
}

std::vector<Outcome> outcomes_with(const std::function<void(PoseEstimate&)>& fault) {
  const std::vector<Method> methods = {method_with(fault)};
  return run_trials(easy_trials(), methods, 2, [](std::size_t) {});
}

std::map<std::string, bool> met(const std::vector<Outcome>& outcomes) {
  std::map<std::string, bool> result;
  for (const Requirement& requirement : pose_requirements(outcomes)) result[requirement.name] = requirement.is_met();
  return result;
}

TEST(PoseBench, FindsNoFaultWhereThereIsNone) {
  const auto outcomes = outcomes_with([](PoseEstimate&) {});
  const auto requirements = met(outcomes);
  EXPECT_TRUE(requirements.at("random scenes: wrong"));
  EXPECT_TRUE(requirements.at("0 % hidden: found"));
  EXPECT_TRUE(requirements.at("centre, median, 1.5 m"));
  const Cell cell = cell_of("all", chosen(outcomes, [](const Outcome&) { return true; }));
  EXPECT_EQ(cell.count, 8);
  EXPECT_EQ(cell.found, 8);
  EXPECT_LT(cell.center_to_bound.value(), 8);
  EXPECT_LT(cell.nees_mean.value(), 30);
}

// Half a per cent too far away: 25 times the error of the honest estimate, and far within what counts as wrong.
TEST(PoseBench, ReportsABiasedEstimator) {
  auto outcomes = outcomes_with([](PoseEstimate& part) { part.pose.center_in_cam *= 1.005; });
  const auto requirements = met(outcomes);
  EXPECT_FALSE(requirements.at("random scenes: mean NEES"));
  EXPECT_FALSE(requirements.at("random scenes: frames below the 95 % quantile"));
  EXPECT_FALSE(requirements.at("centre, median, 1.5 m"));
  EXPECT_TRUE(requirements.at("random scenes: wrong"));
  const Cell cell = cell_of("all", chosen(outcomes, [](const Outcome&) { return true; }));
  EXPECT_NEAR(cell.depth_m->median, 0.0075, 0.001);
  EXPECT_LT(cell.lateral_m->median, 0.001);

  // Only where the bound is above the limit does it count.
  const std::string to_bound = "centre, median / bound, 1.5 m, where that is above 0.03 %";
  EXPECT_EQ(requirements.count(to_bound), 0U);
  for (Outcome& outcome : outcomes) {
    ASSERT_TRUE(outcome.bound);
    outcome.bound->center_m = 0.001;
  }
  EXPECT_FALSE(met(outcomes).at(to_bound));
}

// The bias of a small fraction of a pixel, which only the sign of the depth's errors tells.
TEST(PoseBench, ReportsASmallBias) {
  const auto bias_of = [](double share) {
    const auto outcomes = outcomes_with([=](PoseEstimate& part) { part.pose.center_in_cam *= 1 + share; });
    return cell_of("all", chosen(outcomes, [](const Outcome&) { return true; })).depth_bias.value();
  };
  const double moved_by = bias_of(4e-5) - bias_of(0);
  EXPECT_GT(moved_by, 2);
  EXPECT_LT(moved_by, 8);
}

TEST(PoseBench, ReportsCovariancesThatAreTooSmallOrNone) {
  const auto small = outcomes_with([](PoseEstimate& part) { part.covariance *= 0.01; });
  EXPECT_FALSE(met(small).at("random scenes: mean NEES"));
  const auto none = outcomes_with([](PoseEstimate& part) { part.covariance.setZero(); });
  EXPECT_FALSE(met(none).at("random scenes: mean NEES"));
  EXPECT_FALSE(met(none).at("random scenes: frames below the 95 % quantile"));
}

TEST(PoseBench, CountsWrongPosesAndMissingOnes) {
  int count = 0;
  const std::vector<Method> methods = {method_with([&](PoseEstimate& part) {
    if (++count % 2 == 0) {
      part.pose.axis_in_cam = Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitZ()) * part.pose.axis_in_cam;
    } else if (count == 1) {
      part.status = PoseStatus::kNone;
      part.reason = "a test";
    }
  })};
  const auto outcomes = run_trials(easy_trials(), methods, 1, [](std::size_t) {});
  const Cell cell = cell_of("all", chosen(outcomes, [](const Outcome&) { return true; }));
  EXPECT_EQ(cell.found, 7);
  EXPECT_EQ(cell.wrong, 4);
  EXPECT_FALSE(met(outcomes).at("random scenes: wrong"));
  EXPECT_FALSE(met(outcomes).at("0 % hidden: found"));
  EXPECT_THAT(csv_of(outcomes), HasSubstr("\"a test\""));
  const auto bad = worst(outcomes, 5);
  ASSERT_EQ(bad.size(), 5U);
  EXPECT_TRUE(std::all_of(bad.begin(), bad.begin() + 4, [](const Outcome* o) { return o->wrong; }));
  EXPECT_FALSE(bad[4]->wrong);
}

TEST(PoseBench, ThreadsDoNotChangeTheOutcome) {
  const std::vector<PoseTrial> trials = easy_trials();
  const std::vector<Method> methods = {method_with([](PoseEstimate&) {})};
  const auto alone = run_trials({trials.data(), 3}, methods, 1, [](std::size_t) {});
  std::size_t calls = 0;
  const auto together = run_trials({trials.data(), 3}, methods, 3, [&](std::size_t) { ++calls; });
  EXPECT_EQ(csv_of(alone), csv_of(together));
  EXPECT_EQ(calls, 3U);
}

TEST(PoseBench, PassesOnWhatATrialThrows) {
  std::vector<PoseTrial> trials = easy_trials();
  trials[1].scene.parts[0].cylinder.radius_m = 0;
  const std::vector<Method> methods = {method_with([](PoseEstimate&) {})};
  EXPECT_THROW((void)run_trials({trials.data(), 2}, methods, 2, [](std::size_t) {}), Error);
}

TEST(PoseTrials, AreBalancedAndReproducible) {
  const std::vector<PoseTrial> trials = random_trials(60, 9);
  ASSERT_EQ(trials.size(), 60U);
  std::map<std::string, int> kinds;
  std::map<int, int> distances;
  std::map<int, int> occlusions;
  for (const PoseTrial& trial : trials) {
    ++kinds[trial.scenario];
    ++distances[static_cast<int>(std::lround(10 * trial.distance_m()))];
    ++occlusions[trial.occlusion_percent];
    EXPECT_EQ(trial.occluders.empty(), trial.occlusion_percent == 0);
    EXPECT_EQ(trial.pictures.size(), 2U);
    EXPECT_EQ(trial.pictures[0].variant, kNominal);
  }
  EXPECT_EQ(kinds.size(), 6U);
  for (const auto& [kind, count] : kinds) EXPECT_EQ(count, 10) << kind;
  EXPECT_EQ(distances, (std::map<int, int>{{10, 15}, {15, 15}, {30, 15}, {50, 15}}));
  EXPECT_EQ(occlusions, (std::map<int, int>{{0, 20}, {25, 20}, {50, 20}}));
  const std::vector<PoseTrial> again = random_trials(60, 9);
  const std::vector<PoseTrial> other = random_trials(60, 10);
  EXPECT_EQ(trials[31].truth().center_in_cam, again[31].truth().center_in_cam);
  EXPECT_NE(trials[31].truth().center_in_cam, other[31].truth().center_in_cam);
}

// The bar hides the share that it says, give or take its slant.
TEST(PoseTrials, BarsHideWhatTheySay) {
  for (const PoseTrial& trial : random_trials(36, 4)) {
    if (trial.tilt_deg < 40) continue;
    const CameraModel& camera = trial.scene.camera;
    const auto all = contour_samples(camera, trial.part, trial.truth());
    const auto hidden = std::ranges::count_if(all, [&](const ContourSample& sample) {
      return !trial.occluders.empty() &&
             hides(camera, std::get<BoxSolid>(trial.scene.others.at(trial.occluders[0]).shape), sample.position_px);
    });
    const double share = 100.0 * static_cast<double>(hidden) / static_cast<double>(all.size());
    EXPECT_NEAR(share, trial.occlusion_percent, trial.occlusion_percent == 0 ? 0 : 15) << trial.number;
  }
}

}  // namespace
}  // namespace cylpose::bench
