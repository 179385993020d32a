// What `cylpose` says and does when something is wrong: exit code and message.
#include <gmock/gmock.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cylpose/pose_io.hpp>
#include <opencv2/imgcodecs.hpp>
#include <thread>

#include "scene.hpp"

namespace cylpose {
namespace {

using testing::HasSubstr;

constexpr int kInputError = 2;
constexpr int kOutputError = 3;
constexpr int kDeviceError = 4;
constexpr int kInterrupted = 130;

class RobustInput : public SceneTest {
 protected:
  RobustInput() { write_frames(1); }

  /// Estimates with the given arguments and expects it to be refused: exit code, and every word in the message.
  void expect_refused(const std::vector<std::string>& arguments, int exit_code, const std::vector<std::string>& words) {
    const CommandResult result = estimate(arguments);
    EXPECT_EQ(result.exit_code, exit_code) << result.err;
    for (const std::string& word : words) EXPECT_THAT(result.err, HasSubstr(word));
    EXPECT_THAT(result.err, testing::Not(HasSubstr("internal error")));
  }

  /// Waits until a file has some lines; false when it does not within ten seconds.
  static bool wait_for_lines(const std::string& file, int lines) {
    for (int i = 0; i < 1000; ++i) {
      const std::string text = text_of(file);
      if (std::count(text.begin(), text.end(), '\n') >= lines) return true;
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    return false;
  }

  const std::string image_ = path("frames/frame_0000.png");
};

TEST_F(RobustInput, MissingImage) {
  expect_refused({path("missing.png")}, kInputError, {"missing.png: no such file, folder or camera; check the path"});
}

TEST_F(RobustInput, NothingMatches) {
  expect_refused({path("none_%04d.png")}, kInputError, {"none_%04d.png: no file matches"});
  expect_refused({path("none_*.png")}, kInputError, {"none_*.png: no file matches"});
  std::filesystem::create_directories(path("empty"));
  expect_refused({path("empty")}, kInputError, {"empty: no images in this folder"});
}

TEST_F(RobustInput, MissingCamera) {
  expect_refused({"987"}, kDeviceError, {"camera 987: the camera cannot be opened"});
}

TEST_F(RobustInput, UnreadableImagesAreNoneRowsAndTheRunGoesOn) {
  const std::string whole = text_of(image_);
  const std::string empty = file("empty.png", "");
  const std::string cut = file("cut.png", whole.substr(0, whole.size() / 2));
  const CommandResult result = estimate({image_, empty, cut, image_, "--output", path("poses.csv")});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.err, HasSubstr("empty.png: is empty"));
  EXPECT_THAT(result.err, HasSubstr("cut.png: "));
  EXPECT_THAT(result.err, HasSubstr("4 frames, 2 of 4 poses found, 2 frames unreadable"));
  const std::vector<PoseRow> rows = load_poses(path("poses.csv"));
  ASSERT_EQ(rows.size(), 4U);
  EXPECT_EQ(rows[0].status, PoseStatus::kOk);
  EXPECT_EQ(rows[1].status, PoseStatus::kNone);
  EXPECT_EQ(rows[2].status, PoseStatus::kNone);
  EXPECT_EQ(rows[3].status, PoseStatus::kOk);
  EXPECT_EQ(rows[3].frame, 3);
}

TEST_F(RobustInput, NotOneReadableImage) {
  expect_refused({file("empty.png", "")}, kInputError, {"empty.png: is empty", "none of the images can be read"});
}

TEST_F(RobustInput, SizeDiffersFromTheCalibration) {
  cv::imwrite(path("large.png"), cv::Mat(480, 640, CV_8UC3, cv::Scalar(1, 2, 3)));
  for (const char* method : {"default", "thesis"}) {
    expect_refused({"--method", method, path("large.png")}, kInputError, {"large.png: ", "640 x 480", "320 x 240"});
  }
}

TEST_F(RobustInput, UncalibratedCamera) {
  camera_ = file("camera.yaml", replaced(kCameraText, "[400,", "[0,"));
  expect_refused({image_}, kInputError, {"camera.yaml:", "camera_matrix", "uncalibrated; calibrate the camera"});
}

TEST_F(RobustInput, CameraFileErrors) {
  camera_ = path("nothing.yaml");
  expect_refused({image_}, kInputError, {"nothing.yaml: no such file"});
  camera_ = file("camera.yaml", "");
  expect_refused({image_}, kInputError, {"camera.yaml: is empty"});
  camera_ = file("camera.yaml", std::string(kCameraText).substr(0, 60));
  expect_refused({image_}, kInputError, {"camera.yaml"});
  camera_ = file("camera.yaml", replaced(kCameraText, "[400,", "[.nan,"));
  expect_refused({image_}, kInputError, {"camera.yaml:6: camera_matrix.data[0]: '.nan' is no finite number"});
}

TEST_F(RobustInput, PartFileErrors) {
  parts_ = file("part.yaml", replaced(kPartsText, "[340, 20]", "[20, 20]"));
  expect_refused({image_}, kInputError, {"part.yaml:2:", "part 'can'", "[20, 20] is a range of no width; widen it"});
  parts_ = file("part.yaml", replaced(kPartsText, "0.05", "-0.05"));
  expect_refused({image_}, kInputError, {"part.yaml:2:", "radius_m is -0.05; give metres above 0"});
  parts_ = file("part.yaml", replaced(kPartsText, "0.05", "nan"));
  expect_refused({image_}, kInputError, {"part.yaml:2:", "radius_m: 'nan' is no finite number"});
  parts_ = file("part.yaml", replaced(kPartsText, "radius_m", "radius"));
  expect_refused({image_}, kInputError, {"part.yaml:2:", "unknown key 'radius'", "known keys: name, radius_m"});
  parts_ = file("part.yaml", "");
  expect_refused({image_}, kInputError, {"part.yaml: is empty"});
}

TEST_F(RobustInput, VideoThatEndsInTheMiddle) {
  const std::string bytes = text_of(write_video("whole.avi", 20));
  const std::string cut = file("cut.avi", bytes.substr(0, bytes.size() / 2));
  const CommandResult result = estimate({cut, "--output", path("poses.csv")});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  const std::size_t rows = load_poses(path("poses.csv")).size();
  EXPECT_GT(rows, 3U);
  EXPECT_LT(rows, 17U);
  EXPECT_THAT(result.err, HasSubstr("warning: " + cut + ": ended after " + std::to_string(rows) + " of 20 frames"));
}

TEST_F(RobustInput, VideoThatIsNone) {
  expect_refused({file("clip.mp4", "no video")}, kInputError, {"clip.mp4: is neither an image nor a video"});
  expect_refused({file("empty.mp4", "")}, kInputError, {"empty.mp4: is neither an image nor a video"});
}

TEST_F(RobustInput, UnwritableOutput) {
  const std::string missing = path("missing/poses.csv");
  expect_refused({"--output", missing, image_}, kOutputError, {missing + ": poses cannot be written: No such file"});
  expect_refused({"--output", folder_.path().string(), "--format", "csv", image_}, kOutputError, {"Is a directory"});
  expect_refused({"--output", path("poses.csv"), "--overlay", image_, image_}, kOutputError,
                 {image_ + ": the folder cannot be made"});
  expect_refused({"--output", path("poses.csv"), "--overlay", path("missing/overlay.mp4"), image_}, kOutputError,
                 {"missing/overlay.mp4: the video cannot be written"});
  expect_refused({"--output", path("poses.csv"), "--debug-dir", image_, image_}, kOutputError,
                 {image_ + ": the folder cannot be made"});
}

TEST_F(RobustInput, FullDisk) {
  if (!std::filesystem::exists("/dev/full")) GTEST_SKIP() << "no /dev/full here";
  expect_refused({"--output", "/dev/full", image_}, kOutputError,
                 {"/dev/full: poses cannot be written: No space left"});
  const CommandResult table = RunningCommand({"devices"}, folder_.path(), "/dev/full").wait();
  EXPECT_EQ(table.exit_code, kOutputError);
  EXPECT_THAT(table.err, HasSubstr("standard output: cannot be written"));
}

TEST_F(RobustInput, TheReaderOfThePipeLeaves) {
  const std::string pipe = path("pipe");
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  std::vector<std::string> words = estimate_words({});
  words.insert(words.end(), 1000, image_);
  std::string first;
  std::thread reader([&] {
    std::ifstream stream(pipe);
    std::getline(stream, first);
  });
  const CommandResult result = RunningCommand(words, folder_.path(), pipe).wait();
  reader.join();
  EXPECT_EQ(first, kPosesHeader);
  EXPECT_EQ(result.exit_code, kOutputError);
  EXPECT_THAT(result.err, HasSubstr("standard output: poses cannot be written: Broken pipe"));
}

TEST_F(RobustInput, AnInterruptedRunKeepsWhatIsWritten) {
  for (const int signal : {SIGINT, SIGTERM}) {
    const std::string poses = path("poses.csv");
    std::filesystem::remove(poses);
    std::vector<std::string> words = estimate_words({"--output", poses});
    words.insert(words.end(), 5000, image_);
    RunningCommand command(words, folder_.path());
    ASSERT_TRUE(wait_for_lines(poses, 5));
    command.send(signal);
    const CommandResult result = command.wait();
    EXPECT_EQ(result.exit_code, kInterrupted) << result.err;
    EXPECT_THAT(result.err, HasSubstr("interrupted, everything up to here is written"));
    const std::vector<PoseRow> rows = load_poses(poses);
    EXPECT_GE(rows.size(), 4U);
    EXPECT_LT(rows.size(), 5000U);
    EXPECT_THAT(result.err, HasSubstr(std::to_string(rows.size()) + " frames, "));
  }
}

TEST_F(RobustInput, EvenAKilledRunKeepsWhatIsWritten) {
  const std::string poses = path("poses.csv");
  std::vector<std::string> words = estimate_words({"--output", poses});
  words.insert(words.end(), 5000, image_);
  RunningCommand command(words, folder_.path());
  ASSERT_TRUE(wait_for_lines(poses, 5));
  command.send(SIGKILL);
  EXPECT_EQ(command.wait().exit_code, 128 + SIGKILL);
  EXPECT_GE(load_poses(poses).size(), 4U);
}

TEST_F(RobustInput, UnknownNames) {
  expect_refused({"--method", "magic", image_}, kInputError, {"unknown method 'magic'; known: default, thesis"});
  expect_refused({"--backend", "magic", image_}, kInputError, {"magic", "serial"});
  expect_refused({"--format", "xml", image_}, kInputError, {"--format xml: unknown; write csv, jsonl or tum"});
  expect_refused({"--output", path("poses.xls"), image_}, kInputError,
                 {"poses.xls: the extension .xls tells no format"});
  expect_refused({"--fps", "0", image_}, kInputError, {"fps is 0; give frames per second above 0"});
  expect_refused({"--fps", "fast", image_}, kInputError, {"--fps", "fast"});
  expect_refused({"--colour", "red", image_}, kInputError, {"--colour"});
  expect_refused({}, kInputError, {"INPUT"});
}

TEST_F(RobustInput, RefusedRunsTouchNoOutput) {
  const std::string poses = file("poses.csv", "precious");
  expect_refused({"--output", poses, path("missing.png")}, kInputError, {"missing.png"});
  EXPECT_EQ(text_of(poses), "precious");
}

TEST_F(RobustInput, ATumTrajectoryHoldsOnePart) {
  parts_ = file("part.yaml", std::string(kPartsText) + std::string(replaced(kPartsText, "can", "tin")).substr(7));
  expect_refused({"--format", "tum", image_}, kInputError, {"a TUM trajectory holds one part, not 2"});
}

TEST_F(RobustInput, UsageErrors) {
  EXPECT_EQ(run({}).exit_code, kInputError);
  EXPECT_EQ(run({"guess"}).exit_code, kInputError);
  EXPECT_EQ(run({"--help"}).exit_code, 0);
  const CommandResult version = run({"--version"});
  EXPECT_EQ(version.exit_code, 0);
  EXPECT_THAT(version.out, testing::MatchesRegex("cylpose [0-9]+\\.[0-9]+\\.[0-9]+\n"));
}

TEST_F(RobustInput, EvaluateRefusesWhatItCannotCompare) {
  const std::string header = "frame,cx,cy,cz,ax,ay,az\n";
  const std::string truth = file("truth.csv", header + "0,0,0,1,0,-1,0\n");
  const std::string poses = file("poses.csv", std::string(kPosesHeader) + "\n0,0,can,ok,0,0,1,0,-1,0,1,1,1,1,1\n");
  EXPECT_EQ(run({"evaluate", truth, poses}).exit_code, 0);

  const auto refused = [&](const std::vector<std::string>& arguments, const std::string& words,
                           int code = kInputError) {
    std::vector<std::string> all = {"evaluate"};
    all.insert(all.end(), arguments.begin(), arguments.end());
    const CommandResult result = run(all);
    EXPECT_EQ(result.exit_code, code) << words;
    EXPECT_THAT(result.err, HasSubstr(words));
  };
  refused({path("none.csv"), poses}, "none.csv: no such file");
  refused({file("t.csv", ""), poses}, "t.csv: is empty");
  refused({file("t.csv", header + "0,0,0,nan,0,-1,0\n"), poses}, "t.csv:2: cz is 'nan'");
  refused({truth, file("p.csv", std::string(kPosesHeader) + "\n0,0,can,ok,0,0\n")}, "p.csv:2: has 6 of 15 fields");
  refused({truth, truth}, "no column 'timestamp_s'");
  refused({truth, poses, "--part", "tin"}, "no frame and part in common");
  refused({file("t.csv", header + "7,0,0,1,0,-1,0\n"), poses}, "no frame and part in common");
  refused({truth, poses, "--json", path("missing/report.json")}, "missing/report.json: cannot be written",
          kOutputError);
}

}  // namespace
}  // namespace cylpose
