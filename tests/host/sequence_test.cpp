#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cylpose/error.hpp>
#include <cylpose/pose_io.hpp>
#include <cylpose/sequence.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/videoio.hpp>

#include "temp_dir.hpp"

namespace cylpose {
namespace {

namespace fs = std::filesystem;

SequenceOptions frames_of(int count) {
  SequenceOptions options;
  options.frames = count;
  return options;
}

bool go_on(int /*done*/) {
  return true;
}

TEST(Sequence, TruthHasItsHeaderAndFixedSign) {
  const TempDir dir;
  const fs::path file = dir.path() / "truth.csv";
  save_truth({{{0.1, -0.2, 3}, {0, 1, 0}}, {{0, 0, 1.5}, {0.6, -0.8, 0}}}, file);
  EXPECT_EQ(text_of(file),
            "frame,cx,cy,cz,ax,ay,az\n"
            "0,0.100000000,-0.200000000,3.000000000,0.000000000,-1.000000000,0.000000000\n"
            "1,0.000000000,0.000000000,1.500000000,0.600000000,-0.800000000,0.000000000\n");
  EXPECT_EQ(load_truth(file).size(), 2U);
}

TEST(Sequence, FolderHoldsWhatARecordingWould) {
  const TempDir dir;
  const fs::path folder = dir.path() / "a" / "b";
  const Scenario& scenario = find_scenario("series1");
  int frames_seen = 0;
  const auto files = write_sequence(scenario, frames_of(2), folder, [&](int done) {
    EXPECT_EQ(done, ++frames_seen);
    return true;
  });
  EXPECT_EQ(frames_seen, 2);
  EXPECT_THAT(files,
              testing::UnorderedElementsAre(folder / "truth.csv", folder / "camera.yaml", folder / "parts.yaml"));
  const CameraModel camera = load_camera(folder / "camera.yaml");
  EXPECT_EQ(camera.fx, 1215);
  EXPECT_EQ(camera.cy, 359.5);
  const auto parts = load_parts(folder / "parts.yaml");
  ASSERT_EQ(parts.size(), 1U);
  EXPECT_EQ(parts[0].hue_lo_deg, scenario.parts[0].hue_lo_deg);
  const auto truth = load_truth(folder / "truth.csv");
  ASSERT_EQ(truth.size(), 2U);
  EXPECT_NEAR(truth[0].pose.center_in_cam.z(), 5, 1e-9);
  EXPECT_NEAR(truth[1].pose.center_in_cam.z(), 0.85, 1e-9);
  EXPECT_NEAR(truth[1].pose.axis_in_cam.y(), -1, 1e-9);
  for (int frame = 0; frame < 2; ++frame) {
    const cv::Mat image = cv::imread((folder / ("frame_000" + std::to_string(frame) + ".png")).string());
    EXPECT_EQ(cv::norm(image, sequence_frame(scenario, frames_of(2), frame), cv::NORM_INF), 0);
  }
  EXPECT_FALSE(fs::exists(folder / "frame_0002.png"));
}

TEST(Sequence, FramesDifferInTheirNoise) {
  const Scenario& scenario = find_scenario("fig5.2");  // does not move
  const cv::Mat first = sequence_frame(scenario, frames_of(2), 0);
  EXPECT_GT(cv::norm(first, sequence_frame(scenario, frames_of(2), 1), cv::NORM_INF), 2);
  EXPECT_EQ(cv::norm(first, sequence_frame(scenario, frames_of(2), 0), cv::NORM_INF), 0);
}

TEST(Sequence, StoppedEarlyItKeepsTheTruthOfItsFrames) {
  const TempDir dir;
  write_sequence(find_scenario("series1"), frames_of(5), dir.path(), [](int done) { return done < 2; });
  EXPECT_EQ(load_truth(dir.path() / "truth.csv").size(), 2U);
  EXPECT_TRUE(fs::exists(dir.path() / "frame_0001.png"));
  EXPECT_FALSE(fs::exists(dir.path() / "frame_0002.png"));
}

TEST(Sequence, FramesOfALongerSequenceDoNotStay) {
  const TempDir dir;
  for (const int frames : {4, 2}) write_sequence(find_scenario("series1"), frames_of(frames), dir.path(), go_on);
  EXPECT_TRUE(fs::exists(dir.path() / "frame_0001.png"));
  EXPECT_FALSE(fs::exists(dir.path() / "frame_0002.png"));
  EXPECT_FALSE(fs::exists(dir.path() / "frame_0003.png"));
}

TEST(Sequence, VideoShowsTheSameFrames) {
  const TempDir dir;
  SequenceOptions options = frames_of(3);
  options.video = true;
  const Scenario& scenario = find_scenario("series4");
  const auto files = write_sequence(scenario, options, dir.path(), go_on);
  ASSERT_EQ(files.size(), 4U);
  cv::VideoCapture video(files.back().string());
  ASSERT_TRUE(video.isOpened());
  cv::Mat image;
  int frames = 0;
  while (video.read(image)) {
    const cv::Mat frame = sequence_frame(scenario, options, frames++);
    EXPECT_LT(cv::norm(image, frame, cv::NORM_L1) / static_cast<double>(frame.total() * 3), 6);  // mean, lossy
  }
  EXPECT_EQ(frames, 3);
}

TEST(Sequence, PlacesThatCannotBeWrittenAreNamed) {
  const TempDir dir;
  const fs::path file = dir.write("taken", "a file");
  for (const fs::path& folder : {file, file / "below"}) {
    try {
      write_sequence(find_scenario("series1"), frames_of(1), folder, go_on);
      FAIL();
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::kOutput);
      EXPECT_THAT(error.what(), testing::HasSubstr(folder.string()));
    }
  }
}

TEST(Sequence, OptionsOutOfRangeAreRefused) {
  const TempDir dir;
  for (const int frames : {0, -3, 10001}) {
    EXPECT_THROW(write_sequence(find_scenario("series1"), frames_of(frames), dir.path(), go_on), Error);
  }
  SequenceOptions options = frames_of(1);
  options.noise_sigma = -1;
  EXPECT_THROW(write_sequence(find_scenario("series1"), options, dir.path(), go_on), Error);
}

}  // namespace
}  // namespace cylpose
