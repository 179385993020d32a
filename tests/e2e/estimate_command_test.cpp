// What `cylpose estimate` delivers when all is well.
#include <gmock/gmock.h>

#include <cylpose/pose_io.hpp>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/videoio.hpp>
#include <sstream>

#include "scene.hpp"

namespace cylpose {
namespace {

using testing::HasSubstr;
using EstimateCommand = SceneTest;

void expect_poses_of_frames(const std::vector<PoseRow>& rows, int count) {
  ASSERT_EQ(rows.size(), static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i) {
    const PoseRow& row = rows[static_cast<std::size_t>(i)];
    const CylinderPose truth = with_fixed_sign(pose_of_frame(i));
    EXPECT_EQ(row.frame, i);
    EXPECT_EQ(row.part, "can");
    ASSERT_EQ(row.status, PoseStatus::kOk);
    EXPECT_LT((row.pose.center_in_cam - truth.center_in_cam).norm(), 0.03);
    EXPECT_GT(row.pose.axis_in_cam.dot(truth.axis_in_cam), 0.98);
  }
}

TEST_F(EstimateCommand, WritesCsvToStandardOutputAndASummaryToStandardError) {
  write_frames(3);
  const CommandResult result = estimate({path("frames")});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  expect_poses_of_frames(load_poses(file("poses.csv", result.out)), 3);
  EXPECT_THAT(result.err, HasSubstr("cylpose: 3 frames, 3 of 3 poses found, median rms "));
  EXPECT_THAT(result.err, HasSubstr("frames/s"));
  EXPECT_THAT(result.err, testing::Not(HasSubstr("\r"))) << "no progress bar where there is no terminal";
}

TEST_F(EstimateCommand, GuessesTheFormatFromTheExtension) {
  write_frames(2);
  for (const char* name : {"poses.csv", "poses.jsonl"}) {
    const CommandResult result = estimate({"--output", path(name), path("frames/frame_%04d.png")});
    EXPECT_EQ(result.exit_code, 0) << result.err;
    EXPECT_EQ(result.out, "");
    expect_poses_of_frames(load_poses(path(name)), 2);
  }
  EXPECT_EQ(text_of(path("poses.jsonl"))[0], '{');
  ASSERT_EQ(estimate({"--output", path("poses.tum"), "--fps", "10", path("frames")}).exit_code, 0);
  std::istringstream lines(text_of(path("poses.tum")));
  std::string line;
  std::getline(lines, line);
  std::getline(lines, line);
  EXPECT_THAT(line, testing::StartsWith("0.1 "));
}

TEST_F(EstimateCommand, ExtrinsicsGivePosesInTheBodysFrame) {
  write_frames(2);
  const std::string extrinsics =
      file("extrinsics.yaml", "rotation: [[0, 0, 1], [-1, 0, 0], [0, -1, 0]]\ntranslation_m: [1, 2, 3]\n");
  ASSERT_EQ(estimate({"--output", path("cam.csv"), path("frames")}).exit_code, 0);
  ASSERT_EQ(estimate({"--extrinsics", extrinsics, "--output", path("body.csv"), path("frames")}).exit_code, 0);
  const std::vector<PoseRow> in_cam = load_poses(path("cam.csv"));
  const std::vector<PoseRow> in_body = load_poses(path("body.csv"));
  ASSERT_EQ(in_body.size(), 2U);
  for (std::size_t i = 0; i < 2; ++i) {
    const Eigen::Vector3d& c = in_cam[i].pose.center_in_cam;
    EXPECT_LT((in_body[i].pose.center_in_cam - Eigen::Vector3d(1 + c.z(), 2 - c.x(), 3 - c.y())).norm(), 1e-5);
    EXPECT_NEAR(in_body[i].sigma_center_m.x(), in_cam[i].sigma_center_m.z(), 1e-7);
  }
  const CommandResult refused = estimate({"--extrinsics", file("bad.yaml", "rotation: [1]\n"), path("frames")});
  EXPECT_EQ(refused.exit_code, 2);
  EXPECT_THAT(refused.err, HasSubstr("bad.yaml"));
}

TEST_F(EstimateCommand, FormatOverridesTheExtension) {
  write_frames(1);
  ASSERT_EQ(estimate({"--format", "jsonl", "--output", "-", path("frames")}).exit_code, 0);
  EXPECT_EQ(text_of(path("stdout.txt"))[0], '{');
}

TEST_F(EstimateCommand, AVideoGivesAVideoOfOverlays) {
  const CommandResult result =
      estimate({"--overlay", path("overlay.avi"), "--output", path("poses.csv"), write_video("clip.avi", 4)});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const std::vector<PoseRow> rows = load_poses(path("poses.csv"));
  ASSERT_EQ(rows.size(), 4U);
  EXPECT_DOUBLE_EQ(rows[3].timestamp_s, 0.3);
  cv::VideoCapture overlay(path("overlay.avi"));
  EXPECT_EQ(overlay.get(cv::CAP_PROP_FPS), 10);
  int frames = 0;
  for (cv::Mat picture; overlay.read(picture); ++frames) EXPECT_EQ(picture.size(), cv::Size(320, 240));
  EXPECT_EQ(frames, 4);
}

TEST_F(EstimateCommand, OverlayAndDebugPicturesAreNumberedByFrame) {
  write_frames(2);
  const CommandResult result = estimate(
      {"--overlay", path("new/overlay"), "--debug-dir", path("debug"), "--output", path("poses.csv"), path("frames")});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const cv::Mat input = cv::imread(path("frames/frame_0001.png"));
  const cv::Mat picture = cv::imread(path("new/overlay/frame_0001.png"));
  ASSERT_EQ(picture.size(), input.size());
  EXPECT_GT(cv::norm(picture, input), 0);
  for (const char* stage : {"0_input", "1_mask", "2_edges", "3_chains", "4_segments", "5_lines", "6_pose"}) {
    EXPECT_FALSE(cv::imread(path(std::string("debug/frame_0001_can_") + stage + ".png")).empty()) << stage;
  }
  const cv::Mat mask = cv::imread(path("debug/frame_0000_can_1_mask.png"));
  EXPECT_EQ(mask.at<cv::Vec3b>(120, 160), cv::Vec3b(255, 255, 255)) << "the cylinder's middle is in the mask";
}

TEST_F(EstimateCommand, TimingNamesTheStages) {
  write_frames(2);
  const CommandResult result = estimate({"--timing", "--output", path("poses.csv"), path("frames")});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.err, testing::ContainsRegex("stage \\[ms\\] +mean +median +p95 +frames\n"));
  for (const char* stage : {"decode", "contours", "in the pipeline", "write"}) {
    EXPECT_THAT(result.err, testing::ContainsRegex(std::string("\n") + stage + " +[0-9.]+ +[0-9.]+ +[0-9.]+ +2\n"));
  }
}

TEST_F(EstimateCommand, AFrameWithoutACylinderIsNoneNotAGuess) {
  cv::imwrite(path("wall.png"), cv::Mat(240, 320, CV_8UC3, cv::Scalar(120, 120, 120)));
  const CommandResult result = estimate({path("wall.png")});
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_THAT(result.out, testing::EndsWith("\n0,0,can,none,,,,,,,,,,,\n"));
  EXPECT_THAT(result.err, HasSubstr("1 frames, 0 of 1 poses found"));
}

TEST_F(EstimateCommand, ItsPosesAndTheTruthGiveAnEvaluation) {
  write_frames(3);
  ASSERT_EQ(estimate({"--output", path("poses.csv"), path("frames")}).exit_code, 0);
  std::string truth = "frame,cx,cy,cz,ax,ay,az\n";
  for (int i = 0; i < 4; ++i) {
    const CylinderPose pose = pose_of_frame(i);
    std::ostringstream row;
    row << i << ',' << pose.center_in_cam.x() << ',' << pose.center_in_cam.y() << ',' << pose.center_in_cam.z() << ','
        << pose.axis_in_cam.x() << ',' << pose.axis_in_cam.y() << ',' << pose.axis_in_cam.z() << '\n';
    truth += row.str();
  }
  const std::string truth_path = file("truth.csv", truth);
  const CommandResult table = run({"evaluate", truth_path, path("poses.csv"), "--json", path("report.json")});
  EXPECT_EQ(table.exit_code, 0) << table.err;
  EXPECT_THAT(table.out, HasSubstr("found      3 of 4 (75.0 %); predicted 0, none 0, missing 1"));
  EXPECT_THAT(table.err, HasSubstr("1 of 4 rows of the truth have no row in the poses"));
  const auto report = nlohmann::json::parse(text_of(path("report.json")));
  EXPECT_EQ(report["wrong"], 0);
  EXPECT_LT(report["position_m"]["max"].get<double>(), 0.03);
  const CommandResult json = run({"evaluate", truth_path, path("poses.csv"), "--json", "-", "--part", "can"});
  EXPECT_EQ(nlohmann::json::parse(json.out), report);
}

TEST_F(EstimateCommand, DevicesListsTheBackends) {
  const CommandResult result = run({"devices"});
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_THAT(result.out, testing::ContainsRegex("\n  serial +[a-z]"));
}

}  // namespace
}  // namespace cylpose
