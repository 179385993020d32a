// The cluster's commands as a user runs them.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <csignal>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "host/temp_dir.hpp"
#include "nkey.hpp"
#include "servers.hpp"

namespace cylpose::cluster {
namespace {

using ::cylpose::testing::eventually;
using ::cylpose::testing::NatsServer;
using ::cylpose::testing::Port;
using ::cylpose::testing::Process;
using ::testing::HasSubstr;

class ClusterCommands : public ::testing::Test {
 protected:
  [[nodiscard]] std::string path(const std::string& name) const { return (folder_.path() / name).string(); }

  [[nodiscard]] Process start(std::vector<std::string> words, const std::string& log) const {
    words.insert(words.begin(), CYLPOSE_COMMAND);
    return Process(words, path(log));
  }

  /// Exit code; the output goes to `text`.
  int run(const std::vector<std::string>& words, std::string* text = nullptr) const {
    Process process = start(words, "run.log");
    const int code = process.wait();
    if (text != nullptr) *text = process.output();
    return code;
  }

  void make_frames() const { ASSERT_EQ(run({"synth", "series3", "--frames", "5", "--output", path("frames")}), 0); }

  [[nodiscard]] std::string estimated(const std::vector<std::string>& backend) const {
    std::vector<std::string> words{
        "estimate",        "--camera", path("frames/camera.yaml"), "--parts", path("frames/parts.yaml"), "--output",
        path("poses.csv"), "--backend"};
    words.insert(words.end(), backend.begin(), backend.end());
    words.push_back(path("frames"));
    std::string log;
    EXPECT_EQ(run(words, &log), 0) << log;
    std::ifstream file(path("poses.csv"));
    std::ostringstream text;
    text << file.rdbuf();
    return text.str();
  }

  TempDir folder_;
  NatsServer server_{folder_.path(), "jetstream: {store_dir: \"" + (folder_.path() / "js").string() + "\"}\n"};
};

TEST_F(ClusterCommands, EstimateGivesTheSamePosesWithWorkers) {
  make_frames();
  const Process worker = start({"worker", "--backend", "serial", "--name", "lab", "--server", server_.url()}, "worker");
  std::string nodes;
  ASSERT_TRUE(eventually([&] {
    EXPECT_EQ(run({"nodes", "--server", server_.url()}, &nodes), 0);
    return nodes.find("lab.") != std::string::npos;
  }));
  EXPECT_THAT(nodes, HasSubstr("0 failed"));
  const std::string serial = estimated({"serial"});
  EXPECT_THAT(serial, HasSubstr(",ok,"));
  EXPECT_EQ(estimated({"cluster", "--server", server_.url()}), serial);
}

TEST_F(ClusterCommands, ARecordingIsUploadedAndItsPosesCollected) {
  make_frames();
  std::string log;
  EXPECT_EQ(run({"submit", "--upload", "--name", "flight7", "--job-frames", "2", "--server", server_.url(), "--camera",
                 path("frames/camera.yaml"), "--parts", path("frames/parts.yaml"), path("frames")},
                &log),
            0);
  EXPECT_THAT(log, HasSubstr("5 frames in 3 jobs"));
  std::filesystem::remove_all(path("frames"));
  Process worker = start({"worker", "--jobs", "--backend", "serial", "--server", server_.url()}, "worker");
  std::string poses;
  EXPECT_EQ(run({"collect", "flight7", "--server", server_.url()}, &poses), 0);
  EXPECT_EQ(std::count(poses.begin(), poses.end(), '\n'), 6);
  EXPECT_THAT(poses, HasSubstr("\n4,"));
  EXPECT_THAT(poses, HasSubstr(",ok,"));
  worker.send(SIGTERM);
  EXPECT_EQ(worker.wait(), 0);
}

TEST_F(ClusterCommands, KeyWritesASecretAndPrintsItsPublicKey) {
  std::string printed;
  EXPECT_EQ(run({"key", path("worker1.nk")}, &printed), 0);
  std::ifstream file(path("worker1.nk"));
  std::string seed;
  file >> seed;
  EXPECT_THAT(printed, HasSubstr(public_nkey(seed)));
  EXPECT_EQ(std::filesystem::status(path("worker1.nk")).permissions(),
            std::filesystem::perms::owner_read | std::filesystem::perms::owner_write);
}

TEST_F(ClusterCommands, WithoutAServerTheySayWhatToDo) {
  const Port nobody;
  const std::string url = "nats://127.0.0.1:" + std::to_string(nobody.number());
  for (const std::vector<std::string>& words : {std::vector<std::string>{"nodes"}, {"collect", "flight7"}}) {
    std::vector<std::string> all = words;
    all.insert(all.end(), {"--server", url});
    std::string log;
    EXPECT_EQ(run(all, &log), 4) << words[0];
    EXPECT_THAT(log, HasSubstr("no NATS server answers"));
  }
}

}  // namespace
}  // namespace cylpose::cluster
