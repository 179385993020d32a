// What `cylpose estimate` does with streams: filter, live, window, trace.
#include <gmock/gmock.h>
#include <poll.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <csignal>
#include <cylpose/pose_io.hpp>
#include <fstream>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <thread>

#include "scene.hpp"

namespace cylpose {
namespace {

using testing::HasSubstr;
using StreamCommand = SceneTest;

TEST_F(StreamCommand, TheFilterBridgesAFrameInWhichThePartIsHidden) {
  write_frames(8);
  cv::imwrite(path("frames/frame_0006.png"), cv::Mat(240, 320, CV_8UC3, cv::Scalar(120, 120, 120)));
  ASSERT_EQ(estimate({"--output", path("raw.csv"), path("frames")}).exit_code, 0);
  ASSERT_EQ(estimate({"--filter", "--output", path("filtered.csv"), path("frames")}).exit_code, 0);
  const std::vector<PoseRow> raw = load_poses(path("raw.csv"));
  const std::vector<PoseRow> filtered = load_poses(path("filtered.csv"));
  ASSERT_EQ(filtered.size(), 8U);
  EXPECT_EQ(raw[6].status, PoseStatus::kNone);
  EXPECT_EQ(filtered[6].status, PoseStatus::kPredicted);
  EXPECT_LT((filtered[6].pose.center_in_cam - pose_of_frame(6).center_in_cam).norm(), 0.03);
  EXPECT_EQ(filtered[7].status, PoseStatus::kOk);
}

TEST_F(StreamCommand, ALiveRunPlaysARecordingAtItsOwnSpeed) {
  write_frames(4);
  const auto start = std::chrono::steady_clock::now();
  const CommandResult result = estimate({"--live", "--fps", "10", "--output", path("poses.csv"), path("frames")});
  EXPECT_GE(std::chrono::steady_clock::now() - start, std::chrono::milliseconds(300));
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const std::vector<PoseRow> rows = load_poses(path("poses.csv"));
  ASSERT_FALSE(rows.empty());
  EXPECT_EQ(rows.back().frame, 3) << "the newest frame is never dropped";
  for (const PoseRow& row : rows) EXPECT_DOUBLE_EQ(row.timestamp_s, static_cast<double>(row.frame) / 10);
}

TEST_F(StreamCommand, ATraceShowsEveryFrame) {
  write_frames(3);
  const CommandResult result = estimate({"--trace", path("trace.json"), "--output", path("poses.csv"), path("frames")});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  std::vector<int> frames;
  for (const auto& event : nlohmann::json::parse(text_of(path("trace.json")))) {
    if (event.at("name") == "frame") frames.push_back(event.at("args").at("frame"));
  }
  EXPECT_THAT(frames, testing::UnorderedElementsAre(0, 1, 2));
  EXPECT_EQ(estimate({"--trace", path("no/trace.json"), path("frames")}).exit_code, 3);
}

// An X server without a screen; what it would show lies in a file.
class VirtualScreen {
 public:
  explicit VirtualScreen(const std::string& folder) : file_(folder + "/Xvfb_screen0") {
    std::array<int, 2> ready{};
    if (pipe(ready.data()) != 0) throw std::runtime_error("no pipe");
    const std::string number = std::to_string(ready[1]);
    std::vector<std::string> words{"Xvfb",       "-displayfd", number, "-screen", "0",
                                   "800x600x24", "-nolisten",  "tcp",  "-fbdir",  folder};
    std::vector<char*> argv;
    for (std::string& word : words) argv.push_back(word.data());
    argv.push_back(nullptr);
    if (posix_spawnp(&pid_, "Xvfb", nullptr, nullptr, argv.data(), environ) != 0) pid_ = -1;
    close(ready[1]);
    // The server writes the display's number when it is ready, and closes the pipe when it cannot start.
    for (char c = 0; pid_ != -1 && read(ready[0], &c, 1) == 1 && c != '\n';) display_ += c;
    close(ready[0]);
  }
  ~VirtualScreen() {
    if (pid_ == -1) return;
    kill(pid_, SIGTERM);
    waitpid(pid_, nullptr, 0);
  }
  VirtualScreen(const VirtualScreen&) = delete;
  VirtualScreen& operator=(const VirtualScreen&) = delete;

  [[nodiscard]] const std::string& display() const { return display_; }

  /// Pixels in the yellow of the overlay's cylinder.
  [[nodiscard]] int yellow_pixels() const {
    std::ifstream stream(file_, std::ios::binary);
    const std::string bytes((std::istreambuf_iterator<char>(stream)), {});
    int count = 0;
    for (std::size_t i = 0; i + 3 < bytes.size(); i += 4) {  // B G R x
      const auto code = [&](std::size_t k) { return static_cast<unsigned char>(bytes[i + k]); };
      count += code(0) < 60 && code(1) > 200 && code(2) > 200;
    }
    return count;
  }

 private:
  std::string file_;
  std::string display_;
  pid_t pid_ = -1;
};

TEST_F(StreamCommand, TheWindowShowsTheOverlay) {
  write_frames(4);
  const VirtualScreen screen(folder_.path().string());
  ASSERT_NE(screen.display(), "") << "Xvfb did not start";
  EXPECT_EQ(screen.yellow_pixels(), 0);
  setenv("DISPLAY", (":" + screen.display()).c_str(), 1);
  RunningCommand command(
      estimate_words({"--show", "--live", "--fps", "0.5", "--output", path("poses.csv"), path("frames")}),
      folder_.path());
  unsetenv("DISPLAY");
  const auto give_up = std::chrono::steady_clock::now() + std::chrono::seconds(60);
  while (screen.yellow_pixels() < 50 && std::chrono::steady_clock::now() < give_up) {
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  EXPECT_GE(screen.yellow_pixels(), 50);
  command.send(SIGINT);
  EXPECT_EQ(command.wait().exit_code, 130);
}

TEST_F(StreamCommand, WithoutAScreenShowIsRefused) {
  write_frames(1);
  unsetenv("DISPLAY");
  unsetenv("WAYLAND_DISPLAY");
  const CommandResult result = estimate({"--show", path("frames")});
  EXPECT_EQ(result.exit_code, 3);
  EXPECT_THAT(result.err, HasSubstr("--show: no window can be opened"));
}

}  // namespace
}  // namespace cylpose
