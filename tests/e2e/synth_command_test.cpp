// `cylpose synth` as a user runs it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <csignal>
#include <cylpose/pose_io.hpp>
#include <opencv2/imgcodecs.hpp>
#include <thread>

#include "../host/temp_dir.hpp"
#include "command.hpp"

namespace cylpose {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

class SynthCommand : public testing::Test {
 protected:
  [[nodiscard]] fs::path path(const std::string& name) const { return folder_.path() / name; }
  [[nodiscard]] CommandResult synth(std::vector<std::string> arguments) const {
    arguments.insert(arguments.begin(), "synth");
    return run_cylpose(arguments, folder_.path());
  }

  const TempDir folder_;
};

TEST_F(SynthCommand, WritesASequenceWithTruth) {
  const CommandResult result = synth({"series1", "--output", path("out").string(), "--frames", "3"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.err, HasSubstr("3 of 3 frames"));
  EXPECT_EQ(load_truth(path("out/truth.csv")).size(), 3U);
  const cv::Mat image = cv::imread(path("out/frame_0002.png").string());
  EXPECT_EQ(image.size(), cv::Size(1280, 720));
  EXPECT_FALSE(fs::exists(path("out/frame_0003.png")));
}

TEST_F(SynthCommand, OptionsReachThePicture) {
  const auto frame = [&](const std::string& name, const std::vector<std::string>& options) {
    std::vector<std::string> arguments = {"fig5.2", "--output", path(name).string()};
    arguments.insert(arguments.end(), options.begin(), options.end());
    const CommandResult result = synth(arguments);
    EXPECT_EQ(result.exit_code, 0) << result.err;
    return cv::imread(path(name + "/frame_0000.png").string());
  };
  const cv::Mat seed_1 = frame("a", {"--seed", "1"});
  EXPECT_EQ(cv::norm(seed_1, frame("b", {}), cv::NORM_INF), 0);
  EXPECT_GT(cv::norm(seed_1, frame("c", {"--seed", "2"}), cv::NORM_INF), 2);
  const cv::Mat clean = frame("d", {"--noise", "0"});
  EXPECT_GT(cv::norm(seed_1, clean, cv::NORM_INF), 2);
  EXPECT_EQ(cv::norm(clean, frame("e", {"--noise", "0", "--seed", "2"}), cv::NORM_INF), 0);
  EXPECT_GT(cv::norm(clean, frame("f", {"--noise", "0", "--blur", "3"}), cv::NORM_INF), 20);
}

TEST_F(SynthCommand, ListsScenarios) {
  const CommandResult result = synth({"--list"});
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_THAT(result.out, HasSubstr("series4"));
  EXPECT_THAT(result.out, HasSubstr("candle"));
}

TEST_F(SynthCommand, RefusesWithTheReason) {
  const CommandResult unknown = synth({"series9", "--output", path("x").string()});
  EXPECT_EQ(unknown.exit_code, 2);
  EXPECT_THAT(unknown.err, testing::AllOf(HasSubstr("series9"), HasSubstr("series1"), HasSubstr("candle")));
  EXPECT_FALSE(fs::exists(path("x")));

  const CommandResult no_frames = synth({"series1", "--output", path("x").string(), "--frames", "0"});
  EXPECT_EQ(no_frames.exit_code, 2);
  EXPECT_THAT(no_frames.err, HasSubstr("0 frames"));

  const CommandResult nowhere = synth({"series1", "--output", folder_.write("file", "text").string()});
  EXPECT_EQ(nowhere.exit_code, 3);
  EXPECT_THAT(nowhere.err, HasSubstr(path("file").string()));

  const CommandResult no_name = synth({"--output", path("x").string()});
  EXPECT_EQ(no_name.exit_code, 2);
  EXPECT_THAT(no_name.err, HasSubstr("--list"));
}

TEST_F(SynthCommand, InterruptedItKeepsWhatIsWritten) {
  RunningCommand running({"synth", "series1", "--output", path("out").string()}, folder_.path());
  for (int i = 0; i < 1000 && !fs::exists(path("out/frame_0001.png")); ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  running.send(SIGINT);
  const CommandResult result = running.wait();
  EXPECT_EQ(result.exit_code, 130);
  EXPECT_THAT(result.err, HasSubstr("interrupted"));
  const std::size_t frames = load_truth(path("out/truth.csv")).size();
  EXPECT_GE(frames, 2U);
  EXPECT_LT(frames, 100U);
  EXPECT_FALSE(
      cv::imread((path("out") / ("frame_000" + std::to_string(std::min<std::size_t>(frames, 9) - 1) + ".png")).string())
          .empty());
}

}  // namespace
}  // namespace cylpose
