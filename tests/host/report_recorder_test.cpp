#include <gmock/gmock.h>

#include <cylpose/error.hpp>
#include <cylpose/report_recorder.hpp>
#include <opencv2/imgcodecs.hpp>

namespace cylpose {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::StartsWith;

CameraModel camera() {
  CameraModel camera;
  camera.width = 1280;
  camera.height = 720;
  camera.fx = camera.fy = 1000;
  camera.cx = 640;
  camera.cy = 360;
  return camera;
}

PartModel part(const std::string& name) {
  PartModel part;
  part.name = name;
  part.radius_m = 0.05;
  part.height_m = 0.4;
  return part;
}

Frame frame_numbered(std::int64_t index) {
  Frame frame;
  frame.index = index;
  frame.timestamp_s = 0.5 * static_cast<double>(index);
  frame.image = cv::Mat(720, 1280, CV_8UC3, cv::Scalar(90, 90, 90));
  return frame;
}

FrameEstimate found(double rms_px, double x = 0) {
  PoseEstimate estimate;
  estimate.status = PoseStatus::kOk;
  estimate.pose = {{x, 0, 2}, {0, -1, 0}};
  estimate.rms_px = rms_px;
  estimate.sides = {ImageLine{{1, 0}, 610}, ImageLine{{-1, 0}, -670}};
  return {{}, {estimate}, {}};
}

FrameEstimate not_found() {
  PoseEstimate none;
  none.reason = "one side only";
  return {{}, {none}, {}};
}

std::vector<std::string> captions(const Report& report) {
  std::vector<std::string> all;
  for (const ReportPicture& picture : report.pictures) all.push_back(picture.caption);
  return all;
}

TEST(ReportRecorder, ShowsTheBestAndTheWorstByResidualAndTheFirstNotFound) {
  ReportRecorder recorder(camera(), {part("a")}, {});
  const std::vector<double> residuals = {0.4, 0.1, 0.9, 0.3, 0.2, 0.8};
  for (std::size_t i = 0; i < residuals.size(); ++i) {
    recorder.add(frame_numbered(static_cast<std::int64_t>(i)), found(residuals[i]), 1);
  }
  for (std::int64_t i = 6; i < 9; ++i) recorder.add(frame_numbered(i), not_found(), 1);
  EXPECT_THAT(captions(recorder.report()),
              ElementsAre("Best: frame 1, residual 0.100 px", "Best: frame 4, residual 0.200 px",
                          "Worst: frame 2, residual 0.900 px", "Worst: frame 5, residual 0.800 px",
                          "Not found: frame 6", "Not found: frame 7"));
}

TEST(ReportRecorder, WithTruthTheErrorOfTheCentreDecides) {
  std::vector<TruthRow> truth;
  for (int i = 0; i < 3; ++i) truth.push_back({i, "", {{0, 0, 2}, {0, -1, 0}}});
  ReportRecorder recorder(camera(), {part("a")}, truth);
  recorder.add(frame_numbered(0), found(0.1, 0.003), 1);
  recorder.add(frame_numbered(1), found(0.2, 0.001), 1);
  recorder.add(frame_numbered(2), found(0.3, 0.002), 1);
  EXPECT_THAT(captions(recorder.report()),
              ElementsAre("Best: frame 1, centre off by 1.000 mm", "Best: frame 2, centre off by 2.000 mm",
                          "Worst: frame 0, centre off by 3.000 mm"));
}

TEST(ReportRecorder, PicturesAreSmallOverlaysOfTheFrameAsItWas) {
  ReportRecorder recorder(camera(), {part("a")}, {});
  Frame frame = frame_numbered(0);
  recorder.add(frame, found(0.1), 1);
  frame.image.setTo(cv::Scalar(0, 0, 255));  // a source that uses its pixels again
  const Report report = recorder.report();
  ASSERT_EQ(report.pictures.size(), 1U);
  EXPECT_LT(report.pictures[0].jpeg.size(), 60'000U);
  const cv::Mat picture = cv::imdecode(report.pictures[0].jpeg, cv::IMREAD_COLOR);
  EXPECT_EQ(picture.size(), cv::Size(ReportRecorder::kPictureWidth, 360));
  EXPECT_EQ(report.pictures[0].width, picture.cols);
  EXPECT_EQ(report.pictures[0].height, picture.rows);
  EXPECT_NEAR(picture.at<cv::Vec3b>(350, 10)[2], 90, 3);
  EXPECT_GT(cv::norm(picture, cv::Mat(picture.size(), CV_8UC3, cv::Scalar(90, 90, 90)), cv::NORM_INF), 50)
      << "drawn in";
}

TEST(ReportRecorder, KeepsRowsAndTimes) {
  ReportRecorder recorder(camera(), {part("a")}, {});
  const std::vector<StageTime> times = {{"edges", 1}, {"edges", 2}, {"write", 4}};
  recorder.add(frame_numbered(5), found(0.1), 4);
  recorder.add_times(times);
  const Report report = recorder.report();
  ASSERT_EQ(report.poses.size(), 1U);
  EXPECT_EQ(report.poses[0].frame, 5);
  EXPECT_EQ(report.poses[0].timestamp_s, 2.5);
  EXPECT_EQ(report.poses[0].part, "a");
  EXPECT_EQ(report.poses[0].rms_px, 0.1);
  ASSERT_EQ(report.stages.size(), 2U);
  EXPECT_EQ(report.stages[0].stage, "edges");
  EXPECT_EQ(report.stages[0].milliseconds.median, 3);
  ASSERT_EQ(report.frame_times.size(), 1U);
  EXPECT_EQ(report.frame_times[0].milliseconds, 4);
}

TEST(ReportRecorder, RowsAreInTheFrameOfThePosesFile) {
  Extrinsics extrinsics;
  extrinsics.cam_in_body = {1, 0, 0};
  ReportRecorder recorder(camera(), {part("a")}, {{0, "", {{1, 0, 2.001}, {0, -1, 0}}}}, extrinsics);
  recorder.add(frame_numbered(0), found(0.1), 1);
  EXPECT_EQ(recorder.report().poses[0].pose.center_in_cam, Eigen::Vector3d(1, 0, 2));
  EXPECT_THAT(captions(recorder.report()), ElementsAre("Best: frame 0, centre off by 1.000 mm"));
}

TEST(ReportRecorder, AnUnreadableFrameHasRowsButNoPicture) {
  ReportRecorder recorder(camera(), {part("a")}, {});
  Frame broken;
  broken.index = 3;
  broken.error = "broken.png: cut short";
  recorder.add(broken, not_found(), 1);
  EXPECT_EQ(recorder.report().poses.size(), 1U);
  EXPECT_TRUE(recorder.report().pictures.empty());
}

TEST(ReportRecorder, RefusesTruthThatFitsSeveralPartsBeforeTheRun) {
  const std::vector<TruthRow> truth = {{0, "", {{0, 0, 2}, {0, -1, 0}}}};
  EXPECT_THROW(ReportRecorder(camera(), {part("a"), part("b")}, truth), Error);
  EXPECT_THROW(ReportRecorder(camera(), {part("a")}, {truth[0], truth[0]}), Error);
}

}  // namespace
}  // namespace cylpose
