#include <gmock/gmock.h>

#include <cylpose/error.hpp>
#include <cylpose/pose_io.hpp>
#include <limits>
#include <nlohmann/json.hpp>
#include <numbers>
#include <sstream>

#include "temp_dir.hpp"

namespace cylpose {
namespace {

using testing::HasSubstr;

PoseEstimate some_estimate() {
  PoseEstimate estimate;
  estimate.status = PoseStatus::kOk;
  estimate.pose = with_fixed_sign({{0.1, -1.0 / 3, 1.5}, Eigen::Vector3d(1, -2, 0.5).normalized()});
  estimate.covariance.diagonal() << 1e-6, 4e-6, 9e-6, 1e-4, 1e-4, 1e-4;
  estimate.covariance(0, 2) = estimate.covariance(2, 0) = 1e-7;
  estimate.rms_px = 0.125;
  estimate.support = 321;
  estimate.seen = 0.75;
  return estimate;
}

PoseEstimate no_estimate() {
  PoseEstimate estimate;
  estimate.reason = "no line pair of the part's colour";
  return estimate;
}

class PoseFile : public testing::Test {
 protected:
  std::filesystem::path written(PoseFormat format) {
    const std::filesystem::path path = folder_.path() / "poses";
    PoseWriter writer(path, format, {"candle"});
    writer.write(0, 0.0, {{}, {some_estimate()}, {}});
    writer.write(1, 0.1, {{}, {no_estimate()}, {}});
    writer.close();
    return path;
  }

  template <typename Load>
  std::string refusal(const std::string& text, Load load) {
    try {
      (void)load(folder_.write("file.csv", text));
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::kInput);
      EXPECT_THAT(error.what(), HasSubstr("file.csv"));
      return error.what();
    }
    ADD_FAILURE() << "was accepted:\n" << text;
    return {};
  }

  std::string poses_refusal(const std::string& text) { return refusal(text, load_poses); }
  std::string truth_refusal(const std::string& text) { return refusal(text, load_truth); }

  TempDir folder_;
};

TEST_F(PoseFile, CsvHasTheFixedHeaderAndEmptyFieldsForNone) {
  std::istringstream lines(text_of(written(PoseFormat::kCsv)));
  std::string header, found, none, rest;
  std::getline(lines, header);
  std::getline(lines, found);
  std::getline(lines, none);
  EXPECT_EQ(header, "frame,timestamp_s,part,status,cx,cy,cz,ax,ay,az,sigma_cx,sigma_cy,sigma_cz,sigma_axis_deg,rms_px");
  EXPECT_THAT(found, testing::StartsWith("0,0,candle,ok,0.1,-0.3333333333333333,1.5,"));
  EXPECT_THAT(found, testing::EndsWith(",0.125"));
  EXPECT_EQ(none, "1,0.1,candle,none,,,,,,,,,,,");
  EXPECT_FALSE(std::getline(lines, rest));
}

TEST_F(PoseFile, CsvAndJsonLinesReadBackTheSameNumbers) {
  const PoseEstimate estimate = some_estimate();
  for (const PoseFormat format : {PoseFormat::kCsv, PoseFormat::kJsonl}) {
    const std::vector<PoseRow> rows = load_poses(written(format));
    ASSERT_EQ(rows.size(), 2U);
    EXPECT_EQ(rows[0].frame, 0);
    EXPECT_EQ(rows[0].part, "candle");
    EXPECT_EQ(rows[0].status, PoseStatus::kOk);
    EXPECT_EQ(rows[0].pose.center_in_cam, estimate.pose.center_in_cam);
    EXPECT_LT((rows[0].pose.axis_in_cam - estimate.pose.axis_in_cam).norm(), 1e-15);
    EXPECT_LT((rows[0].sigma_center_m - Eigen::Vector3d(1e-3, 2e-3, 3e-3)).norm(), 1e-15);
    EXPECT_NEAR(rows[0].sigma_axis_deg, 0.01 * 180 / std::numbers::pi, 1e-12);
    EXPECT_EQ(rows[0].rms_px, 0.125);
    EXPECT_EQ(rows[1].frame, 1);
    EXPECT_EQ(rows[1].timestamp_s, 0.1);
    EXPECT_EQ(rows[1].status, PoseStatus::kNone);
  }
}

TEST_F(PoseFile, JsonLinesCarryTheWholeCovarianceAndTheReason) {
  std::istringstream lines(text_of(written(PoseFormat::kJsonl)));
  std::string line;
  std::getline(lines, line);
  const auto found = nlohmann::json::parse(line);
  ASSERT_EQ(found["covariance"].size(), 36U);
  for (int r = 0; r < 6; ++r) {
    for (int c = 0; c < 6; ++c) {
      EXPECT_EQ(found["covariance"][static_cast<std::size_t>(6 * r + c)], some_estimate().covariance(r, c));
    }
  }
  EXPECT_EQ(found["support"], 321);
  std::getline(lines, line);
  const auto none = nlohmann::json::parse(line);
  EXPECT_EQ(none["status"], "none");
  EXPECT_EQ(none["reason"], "no line pair of the part's colour");
  EXPECT_FALSE(none.contains("center_m"));
}

TEST_F(PoseFile, TumSkipsFramesWithoutAPose) {
  std::istringstream lines(text_of(written(PoseFormat::kTum)));
  std::string first, rest;
  std::getline(lines, first);
  EXPECT_FALSE(std::getline(lines, rest));
  std::istringstream numbers(first);
  double t, x, y, z, qx, qy, qz, qw;
  ASSERT_TRUE(numbers >> t >> x >> y >> z >> qx >> qy >> qz >> qw);
  EXPECT_EQ(Eigen::Vector3d(x, y, z), some_estimate().pose.center_in_cam);
  const Eigen::Quaterniond rotation(qw, qx, qy, qz);
  EXPECT_LT((rotation * Eigen::Vector3d::UnitZ() - some_estimate().pose.axis_in_cam).norm(), 1e-12);
}

TEST_F(PoseFile, TumRefusesSeveralParts) {
  EXPECT_THROW(PoseWriter(folder_.path() / "poses.tum", PoseFormat::kTum, {"a", "b"}), Error);
}

TEST_F(PoseFile, SeveralPartsGiveARowEach) {
  const std::filesystem::path path = folder_.path() / "poses.csv";
  PoseWriter writer(path, PoseFormat::kCsv, {"a", "b"});
  writer.write(7, 0.7, {{}, {no_estimate(), some_estimate()}, {}});
  // Not closed: what was written must be there already.
  const std::vector<PoseRow> rows = load_poses(path);
  ASSERT_EQ(rows.size(), 2U);
  EXPECT_EQ(rows[0].part, "a");
  EXPECT_EQ(rows[0].status, PoseStatus::kNone);
  EXPECT_EQ(rows[1].part, "b");
  EXPECT_EQ(rows[1].status, PoseStatus::kOk);
  EXPECT_EQ(rows[1].frame, 7);
}

TEST_F(PoseFile, WritingErrorsNameTheDestination) {
  try {
    PoseWriter(folder_.path() / "missing" / "poses.csv", PoseFormat::kCsv, {"a"});
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::kOutput);
    EXPECT_THAT(error.what(), HasSubstr("missing/poses.csv"));
  }
}

TEST_F(PoseFile, AFullDiskIsReportedWithTheFirstRowThatDoesNotFit) {
  if (!std::filesystem::exists("/dev/full")) GTEST_SKIP() << "no /dev/full here";
  try {
    PoseWriter writer("/dev/full", PoseFormat::kTum, {"a"});
    writer.write(0, 0, {{}, {some_estimate()}, {}});
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::kOutput);
    EXPECT_THAT(error.what(), HasSubstr("/dev/full: poses cannot be written: No space left"));
  }
}

TEST_F(PoseFile, CrlfAndEmptyLinesAndOtherColumnsAreFine) {
  const std::vector<TruthRow> rows = load_truth(
      folder_.write("truth.csv", "frame,cx,cy,cz,ax,ay,az,blur\r\n0, 1, 2, 3, 0, -1, 0, x\r\n\r\n4,1,2,3,0,-1,0,y"));
  ASSERT_EQ(rows.size(), 2U);
  EXPECT_EQ(rows[0].pose.center_in_cam, Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(rows[0].pose.axis_in_cam, Eigen::Vector3d(0, -1, 0));
  EXPECT_EQ(rows[0].part, "");
  EXPECT_EQ(rows[1].frame, 4);
}

TEST_F(PoseFile, TruthMayNameParts) {
  const std::vector<TruthRow> rows =
      load_truth(folder_.write("truth.csv", "part,frame,cx,cy,cz,ax,ay,az\nlink,0,1,2,3,0,-1,0\n"));
  ASSERT_EQ(rows.size(), 1U);
  EXPECT_EQ(rows[0].part, "link");
}

TEST_F(PoseFile, TruthRefusalsNameLineAndValue) {
  const std::string header = "frame,cx,cy,cz,ax,ay,az\n";
  EXPECT_THAT(truth_refusal(""), HasSubstr("is empty"));
  EXPECT_THAT(truth_refusal("frame,x,y,z\n"),
              HasSubstr("file.csv:1: the header has no column 'cx'; it needs frame,cx"));
  EXPECT_THAT(truth_refusal(header + "0,1,2\n"), HasSubstr("file.csv:2: has 3 of 7 fields"));
  EXPECT_THAT(truth_refusal(header + "0,1,2,nan,0,-1,0\n"), HasSubstr("file.csv:2: cz is 'nan'"));
  EXPECT_THAT(truth_refusal(header + "0,1,2,3,0,-1,0\n1,1,2,3,0,-1,inf\n"), HasSubstr("file.csv:3: az is 'inf'"));
  EXPECT_THAT(truth_refusal(header + "-1,1,2,3,0,-1,0\n"), HasSubstr("frame is '-1'"));
  EXPECT_THAT(truth_refusal(header + "0.5,1,2,3,0,-1,0\n"), HasSubstr("frame is '0.5'"));
  EXPECT_THAT(truth_refusal(header + "0,1,2,,0,-1,0\n"), HasSubstr("cz is ''"));
  EXPECT_THAT(truth_refusal(header + "0,1,2,3 m,0,-1,0\n"), HasSubstr("cz is '3 m'"));
  EXPECT_THAT(truth_refusal(header + "0,1,2,3,0,0,0\n"), HasSubstr("length 0; expected a unit vector"));
  EXPECT_THROW((void)load_truth(folder_.path() / "none.csv"), Error);
}

TEST_F(PoseFile, PosesRefusalsNameLineAndValue) {
  const std::string header = std::string(kPosesHeader) + "\n";
  EXPECT_THAT(poses_refusal("frame,cx,cy,cz,ax,ay,az\n"), HasSubstr("no column 'timestamp_s'"));
  EXPECT_THAT(poses_refusal(header + "0,0,candle,good,1,2,3,0,-1,0,1,1,1,1,1\n"),
              HasSubstr("file.csv:2: status is 'good'; expected ok, predicted or none"));
  EXPECT_THAT(poses_refusal(header + "0,0,candle,ok,nan,2,3,0,-1,0,1,1,1,1,1\n"), HasSubstr("cx is 'nan'"));
  EXPECT_THAT(poses_refusal(header + "0,0,candle,ok,,,,,,,,,,,\n"), HasSubstr("ax is ''"));
  EXPECT_THAT(poses_refusal(header + "0,0,candle,ok,1,2,3,0,-1"), HasSubstr("9 of 15 fields"));
}

TEST_F(PoseFile, JsonLinesRefusalsNameTheLine) {
  const std::string good = R"({"frame":0,"timestamp_s":0,"part":"a","status":"none"})";
  EXPECT_THAT(poses_refusal(good + "\n" + good.substr(0, 20)), HasSubstr("file.csv:2: "));
  EXPECT_THAT(poses_refusal(R"({"frame":0,"timestamp_s":0,"status":"none"})"), HasSubstr("'part'"));
  EXPECT_THAT(poses_refusal(R"({"frame":0.5,"timestamp_s":0,"part":"a","status":"none"})"), HasSubstr("frame is 0.5"));
  EXPECT_THAT(poses_refusal(R"({"frame":0,"timestamp_s":0,"part":"a","status":"bad"})"), HasSubstr("\"bad\""));
  EXPECT_THAT(
      poses_refusal(R"({"frame":0,"timestamp_s":0,"part":"a","status":"ok","center_m":[1,2,null],"axis":[0,-1,0]})"),
      HasSubstr("null"));
  EXPECT_THAT(poses_refusal(R"({"frame":0,"timestamp_s":0,"part":"a","status":"ok","center_m":[1,2,3],"axis":[0,1]})"),
              HasSubstr("axis is [0,1]; expected three numbers"));
}

TEST_F(PoseFile, JsonLinesNestedBeyondReasonAreRefused) {
  // Deep enough that one call per level would run out of stack.
  const std::string nested = std::string(200'000, '[') + std::string(200'000, ']');
  EXPECT_THAT(poses_refusal(R"({"frame":)" + nested + "}"), HasSubstr("file.csv:1: is nested deeper than"));
  EXPECT_THAT(poses_refusal(R"({"frame":0,"timestamp_s":0,"part":"a","status":"ok","axis":)" + nested + "}"),
              HasSubstr("file.csv:1: is nested deeper than"));
}

TEST(PoseFormatName, OnlyTheThreeFormatsAreKnown) {
  EXPECT_EQ(pose_format_from("csv"), PoseFormat::kCsv);
  EXPECT_EQ(pose_format_from("jsonl"), PoseFormat::kJsonl);
  EXPECT_EQ(pose_format_from("tum"), PoseFormat::kTum);
  EXPECT_FALSE(pose_format_from("CSV"));
}

TEST(CamFromCylRotation, ZIsTheAxisAndXLeansTowardTheCamerasX) {
  for (const Eigen::Vector3d& direction :
       {Eigen::Vector3d(0, -1, 0), Eigen::Vector3d(0.3, -0.2, 0.9), Eigen::Vector3d(1, 0, 0),
        Eigen::Vector3d(0.9995, -0.01, 0), Eigen::Vector3d(0, 0, 1), Eigen::Vector3d(-0.5, -0.5, -0.7)}) {
    const Eigen::Vector3d axis = direction.normalized();
    const Eigen::Quaterniond q = cam_from_cyl_rotation(axis);
    EXPECT_NEAR(q.norm(), 1, 1e-12);
    EXPECT_GE(q.w(), 0);
    EXPECT_LT((q * Eigen::Vector3d::UnitZ() - axis).norm(), 1e-12);
    const Eigen::Vector3d x = q * Eigen::Vector3d::UnitX();
    const Eigen::Vector3d guide =
        axis.x() > 0.999 ? Eigen::Vector3d(Eigen::Vector3d::UnitY()) : Eigen::Vector3d(Eigen::Vector3d::UnitX());
    EXPECT_GT(x.dot(guide), 0);
    EXPECT_NEAR(x.dot(axis.cross(guide)), 0, 1e-12) << "x lies in the plane of the axis and the guide";
  }
}

}  // namespace
}  // namespace cylpose
