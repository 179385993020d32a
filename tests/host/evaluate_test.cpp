#include <gmock/gmock.h>

#include <cmath>
#include <cylpose/error.hpp>
#include <cylpose/evaluate.hpp>
#include <limits>
#include <nlohmann/json.hpp>
#include <numbers>
#include <random>

namespace cylpose {
namespace {

using testing::HasSubstr;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

CylinderPose upright(double x, double y, double z) {
  return {{x, y, z}, {0, -1, 0}};
}

/// An upright axis tilted in the image plane.
CylinderPose tilted(double degrees) {
  const double angle = degrees * std::numbers::pi / 180;
  return {{0, 0, 2}, {std::sin(angle), -std::cos(angle), 0}};
}

PoseRow row(std::int64_t frame, const CylinderPose& pose, PoseStatus status = PoseStatus::kOk,
            const std::string& part = "a") {
  PoseRow result;
  result.frame = frame;
  result.part = part;
  result.status = status;
  result.pose = pose;
  return result;
}

std::string refusal(const std::vector<TruthRow>& truth, const std::vector<PoseRow>& poses,
                    const EvaluateOptions& options = {}) {
  try {
    (void)evaluate(truth, poses, options);
  } catch (const Error& error) {
    return error.what();
  }
  ADD_FAILURE() << "was accepted";
  return {};
}

TEST(PoseError, SplitsTheCentreErrorAlongTheLineOfSight) {
  const PoseError error = pose_error(upright(0.003, 0.004, 2.012), upright(0, 0, 2));
  EXPECT_NEAR(error.position_m, 0.013, 1e-12);
  EXPECT_NEAR(error.depth_m, 0.012, 1e-12);
  EXPECT_NEAR(error.lateral_m, 0.003, 1e-12);
  EXPECT_NEAR(error.along_axis_m, 0.004, 1e-12);
  EXPECT_NEAR(error.axis_line_m, std::hypot(0.003, 0.012), 1e-12);
  EXPECT_EQ(error.axis_angle_deg, 0);
}

TEST(PoseError, DepthIsAlongTheLineOfSightNotTheCamerasZ) {
  const PoseError error = pose_error(upright(1.01, 0, 1.01), upright(1, 0, 1));
  EXPECT_NEAR(error.depth_m, std::sqrt(2) * 0.01, 1e-12);
  EXPECT_NEAR(error.lateral_m, 0, 1e-12);
}

TEST(PoseError, ThePartsOfTheCentreErrorArePerpendicular) {
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  const auto vector = [&] { return Eigen::Vector3d(normal(random), normal(random), normal(random)); };
  for (int i = 0; i < 100; ++i) {
    const PoseError error = pose_error({vector(), vector().normalized()}, {vector(), vector().normalized()});
    EXPECT_NEAR(error.position_m, std::hypot(error.depth_m, error.lateral_m, error.along_axis_m), 1e-12);
  }
}

TEST(PoseError, AnAxisTowardTheCameraHasNoAlongAxisPart) {
  const PoseError error = pose_error({{0.3, 0.4, 2}, {0, 0, 1}}, {{0, 0, 2}, {0, 0, 1}});
  EXPECT_EQ(error.along_axis_m, 0);
  EXPECT_NEAR(error.lateral_m, 0.5, 1e-12);
}

TEST(PoseError, TheSignOfTheAxisDoesNotCount) {
  CylinderPose flipped = tilted(3);
  flipped.axis_in_cam = -flipped.axis_in_cam;
  EXPECT_NEAR(pose_error(flipped, tilted(0)).axis_angle_deg, 3, 1e-9);
  EXPECT_NEAR(pose_error(tilted(90), tilted(0)).axis_angle_deg, 90, 1e-9);
  EXPECT_NEAR(pose_error(tilted(120), tilted(0)).axis_angle_deg, 60, 1e-9);
  EXPECT_NEAR(pose_error(tilted(1e-5), tilted(0)).axis_angle_deg, 1e-5, 1e-12) << "no loss of digits near 0";
}

TEST(PoseError, FailsOnNanAnywhere) {
  for (int i = 0; i < 3; ++i) {
    CylinderPose center = tilted(0);
    center.center_in_cam[i] = kNan;
    EXPECT_THROW((void)pose_error(center, tilted(0)), Error);
    EXPECT_THROW((void)pose_error(tilted(0), center), Error);
    CylinderPose axis = tilted(0);
    axis.axis_in_cam[i] = kNan;
    EXPECT_THROW((void)pose_error(axis, tilted(0)), Error);
    EXPECT_THROW((void)pose_error(tilted(0), axis), Error);
  }
  EXPECT_THROW((void)pose_error({{0, 0, 2}, {0, 0, 0}}, tilted(0)), Error);
}

TEST(StatisticsOf, MeanMedianP95AndMax) {
  std::vector<double> values;
  for (int i = 100; i >= 0; --i) values.push_back(i);
  const auto statistics = statistics_of(values);
  ASSERT_TRUE(statistics);
  EXPECT_DOUBLE_EQ(statistics->mean, 50);
  EXPECT_DOUBLE_EQ(statistics->median, 50);
  EXPECT_DOUBLE_EQ(statistics->p95, 95);
  EXPECT_DOUBLE_EQ(statistics->max, 100);
  EXPECT_DOUBLE_EQ(statistics_of({1, 2})->median, 1.5);
  EXPECT_FALSE(statistics_of({}));
  EXPECT_THROW((void)statistics_of({1, kNan}), Error);
}

TEST(Evaluate, CountsEveryRowOnce) {
  std::vector<TruthRow> truth;
  for (int frame = 0; frame < 5; ++frame) truth.push_back({frame, "", tilted(0)});
  const std::vector<PoseRow> poses = {row(0, tilted(0)), row(1, tilted(11)), row(2, tilted(0), PoseStatus::kNone),
                                      row(3, tilted(0), PoseStatus::kPredicted), row(9, tilted(0))};
  const Evaluation result = evaluate(truth, poses);
  EXPECT_EQ(result.expected, 5);
  EXPECT_EQ(result.ok, 2);
  EXPECT_EQ(result.wrong, 1);
  EXPECT_EQ(result.none, 1);
  EXPECT_EQ(result.predicted, 1);
  EXPECT_EQ(result.missing, 1);
  EXPECT_EQ(result.surplus, 1);
  EXPECT_DOUBLE_EQ(result.found_rate(), 0.4);
  ASSERT_TRUE(result.axis_angle_deg);
  EXPECT_NEAR(result.axis_angle_deg->mean, 5.5, 1e-9);
  ASSERT_EQ(result.warnings().size(), 2U);
  EXPECT_THAT(result.warnings()[0], HasSubstr("1 of 5 rows of the truth have no row"));
  EXPECT_THAT(result.warnings()[1], HasSubstr("1 rows of the poses have no truth"));
}

TEST(Evaluate, MeanPositionErrorIsTheThesissEquation) {
  const std::vector<TruthRow> truth = {{0, "", upright(0, 0, 2)}, {1, "", upright(0, 0, 2)}};
  const Evaluation result =
      evaluate(truth, std::vector<PoseRow>{row(0, upright(0.03, 0.04, 2)), row(1, upright(0, 0, 2.01))});
  EXPECT_NEAR(result.position_m->mean, (0.05 + 0.01) / 2, 1e-12);
  EXPECT_TRUE(result.warnings().empty());
}

TEST(Evaluate, PartsAreMatchedByName) {
  const std::vector<TruthRow> truth = {{0, "a", tilted(0)}, {0, "b", tilted(20)}};
  const std::vector<PoseRow> poses = {row(0, tilted(20), PoseStatus::kOk, "b"),
                                      row(0, tilted(0), PoseStatus::kOk, "a")};
  const Evaluation both = evaluate(truth, poses);
  EXPECT_EQ(both.ok, 2);
  EXPECT_EQ(both.wrong, 0);
  const Evaluation one = evaluate(truth, poses, {.part = "b"});
  EXPECT_EQ(one.expected, 1);
  EXPECT_EQ(one.ok, 1);
  EXPECT_EQ(one.surplus, 0);
}

TEST(Evaluate, RefusesWhatCannotBeCompared) {
  const std::vector<TruthRow> truth = {{0, "", tilted(0)}};
  const PoseRow a = row(0, tilted(0));
  const PoseRow b = row(0, tilted(0), PoseStatus::kOk, "b");
  EXPECT_THAT(refusal(truth, {a, b}), HasSubstr("the parts a, b"));
  EXPECT_EQ(evaluate(truth, std::vector<PoseRow>{a, b}, {.part = "b"}).ok, 1);
  EXPECT_THAT(refusal(truth, {a, a}), HasSubstr("frame 0, part a: given twice in the poses"));
  EXPECT_THAT(refusal({truth[0], truth[0]}, {a}), HasSubstr("given twice in the truth"));
  EXPECT_THAT(refusal(truth, {}), HasSubstr("no frame and part in common"));
  EXPECT_THAT(refusal(truth, {row(1, tilted(0))}), HasSubstr("no frame and part in common"));
  EXPECT_THAT(refusal({{0, "b", tilted(0)}}, {a}), HasSubstr("named alike"));
  EXPECT_THAT(refusal(truth, {a}, {.wrong_axis_deg = kNan}), HasSubstr("wrong_axis_deg is nan"));
  EXPECT_THAT(refusal(truth, {row(0, {{kNan, 0, 0}, {0, -1, 0}})}), HasSubstr("cannot be compared"));
}

TEST(EvaluateReport, TextAndJsonSayTheSame) {
  const std::vector<TruthRow> truth = {{0, "", upright(0, 0, 2)}, {1, "", upright(0, 0, 2)}};
  const Evaluation result = evaluate(
      truth, std::vector<PoseRow>{row(0, upright(0.003, 0.004, 2.012)), row(1, upright(0, 0, 2), PoseStatus::kNone)});
  const std::string text = to_text(result);
  EXPECT_THAT(text, HasSubstr("found      1 of 2 (50.0 %); predicted 0, none 1, missing 0\n"));
  EXPECT_THAT(text, testing::ContainsRegex("depth +\\[mm\\] +12\\.0000 +12\\.0000 +12\\.0000 +12\\.0000\n"));
  EXPECT_THAT(text, HasSubstr("equation 5.4): 0.013000 m"));
  const auto json = nlohmann::json::parse(to_json(result));
  EXPECT_EQ(json["found_rate"], 0.5);
  EXPECT_NEAR(json["depth_m"]["p95"].get<double>(), 0.012, 1e-12);
  EXPECT_NEAR(json["mean_position_error_m"].get<double>(), 0.013, 1e-12);
}

TEST(EvaluateReport, NothingFoundIsNoZeroError) {
  const std::vector<TruthRow> truth = {{0, "", upright(0, 0, 2)}};
  const Evaluation result = evaluate(truth, std::vector<PoseRow>{row(0, upright(0, 0, 2), PoseStatus::kNone)});
  EXPECT_FALSE(result.position_m);
  EXPECT_TRUE(nlohmann::json::parse(to_json(result))["position_m"].is_null());
  EXPECT_TRUE(nlohmann::json::parse(to_json(result))["mean_position_error_m"].is_null());
  EXPECT_THAT(to_text(result), HasSubstr("-"));
}

}  // namespace
}  // namespace cylpose
