// Archives: every frame once and in order, whatever dies meanwhile.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <csignal>
#include <cylpose/cluster/archive.hpp>
#include <cylpose/error.hpp>
#include <filesystem>
#include <fstream>
#include <opencv2/imgcodecs.hpp>
#include <random>
#include <thread>

#include "host/temp_dir.hpp"
#include "job_store.hpp"
#include "servers.hpp"

namespace cylpose::cluster {
namespace {

using ::cylpose::testing::eventually;
using ::cylpose::testing::NatsServer;
using ::cylpose::testing::Process;
using ::testing::HasSubstr;

constexpr const char* kCamera =
    "image_width: 64\nimage_height: 48\ncamera_matrix: {rows: 3, cols: 3, data: [80, 0, 32, 0, 80, 24, 0, 0, 1]}\n"
    "distortion_model: plumb_bob\ndistortion_coefficients: {rows: 1, cols: 5, data: [0, 0, 0, 0, 0]}\n";
constexpr const char* kParts =
    "parts:\n  - {name: link, radius_m: 0.05, height_m: 0.4, hue_deg: [200, 260], min_saturation: 0.3, min_value: "
    "0.2}\n";

class Archives : public ::testing::Test {
 protected:
  Archives() {
    archive_.name = "run1";
    archive_.camera_yaml = kCamera;
    archive_.parts_yaml = kParts;
    archive_.frames_per_job = 3;
    connection_.servers = {server_.url()};
  }

  void make_frames(int count) {
    for (int i = 0; i < count; ++i) {
      const cv::Mat image(48, 64, CV_8UC3, cv::Scalar(i, 40, 60));
      const std::string path = (folder_.path() / ("frame" + std::to_string(i) + ".png")).string();
      ASSERT_TRUE(cv::imwrite(path, image));
      archive_.files.push_back(path);
    }
  }

  Process worker(int i) {
    return Process({CYLPOSE_COMMAND, "worker", "--jobs", "--backend", "serial", "--server", server_.url()},
                   folder_.path() / ("worker" + std::to_string(i) + ".log"));
  }

  std::string collected(const std::function<bool()>& stop = [] { return false; }) {
    std::string text;
    collect_archive(
        connection_, "run1", [&](std::string_view more) { text += more; }, stop);
    return text;
  }

  // All frames, each once, in order.
  static void expect_rows(const std::string& text, int count) {
    std::istringstream lines(text);
    std::string line;
    ASSERT_TRUE(std::getline(lines, line));
    EXPECT_EQ(line, kPosesHeader);
    for (int i = 0; i < count; ++i) {
      ASSERT_TRUE(std::getline(lines, line)) << i;
      EXPECT_THAT(line, ::testing::StartsWith(std::to_string(i) + ","));
    }
    EXPECT_FALSE(std::getline(lines, line)) << line;
  }

  TempDir folder_;
  NatsServer server_{folder_.path(), "jetstream: {store_dir: \"" + (folder_.path() / "js").string() + "\"}\n"};
  ConnectionOptions connection_;
  Archive archive_;
};

TEST_F(Archives, ComeOutInOrder) {
  make_frames(10);
  archive_.files[4] = "/no/such/file.png";
  EXPECT_EQ(submit_archive(connection_, archive_), 4);
  const Process first = worker(0);
  const Process second = worker(1);
  expect_rows(collected(), 10);
  expect_rows(collected(), 10);  // gathering takes nothing away
}

TEST_F(Archives, LoseAndDoubleNothingWhenWorkersAndServersAreKilled) {
  make_frames(60);
  EXPECT_EQ(submit_archive(connection_, archive_), 20);
  std::vector<Process> workers;
  for (int i = 0; i < 2; ++i) workers.push_back(worker(i));
  std::string text;
  std::jthread collector([&] { text = collected(); });
  for (int kill = 0; kill < 4; ++kill) {
    workers[static_cast<std::size_t>(kill % 2)].kill();
    workers[static_cast<std::size_t>(kill % 2)] = worker(kill % 2);
    if (kill % 2 == 1) {
      server_.kill();
      server_.restart();
    }
  }
  collector.join();
  expect_rows(text, 60);
}

TEST_F(Archives, WaitForAServerThatIsBeingRestarted) {
  make_frames(3);
  const auto restarted_meanwhile = [this](const std::function<void()>& what) {
    server_.kill();
    std::jthread restart([this] {
      std::this_thread::sleep_for(std::chrono::milliseconds(300));
      server_.restart();
    });
    what();
  };
  restarted_meanwhile([this] { EXPECT_EQ(submit_archive(connection_, archive_), 1); });
  const Process first = worker(0);
  restarted_meanwhile([this] { expect_rows(collected(), 3); });
}

TEST_F(Archives, UploadedFramesNeedNoFiles) {
  TempDir folder;
  const NatsServer small(folder.path(),
                         "max_payload: 8192\njetstream: {store_dir: \"" + (folder.path() / "js").string() + "\"}\n");
  connection_.servers = {small.url()};
  std::mt19937 random(5);
  for (int i = 0; i < 7; ++i) {
    cv::Mat image(48, 64, CV_8UC3);
    for (cv::Vec3b& pixel : cv::Mat_<cv::Vec3b>(image)) pixel = cv::Vec3b::all(static_cast<std::uint8_t>(random()));
    const std::string path = (folder_.path() / ("noise" + std::to_string(i) + ".png")).string();
    ASSERT_TRUE(cv::imwrite(path, image));
    archive_.files.push_back(path);
  }
  std::ofstream(archive_.files[6]) << "no image";
  archive_.upload = true;
  archive_.format = PoseFormat::kJsonl;
  EXPECT_EQ(submit_archive(connection_, archive_), 3);
  for (const std::string& file : archive_.files) std::filesystem::remove(file);
  const Process first({CYLPOSE_COMMAND, "worker", "--jobs", "--backend", "serial", "--server", small.url()},
                      folder_.path() / "worker.log");
  std::istringstream lines(collected());
  std::string line;
  for (int i = 0; i < 7; ++i) {
    ASSERT_TRUE(std::getline(lines, line)) << i;
    EXPECT_THAT(line, HasSubstr("\"frame\":" + std::to_string(i) + ","));
    EXPECT_EQ(line.find("no such file") != std::string::npos, false) << line;
    EXPECT_EQ(line.find("frame0.png") != std::string::npos, i == 6) << "only the last one cannot be read: " << line;
  }
  const Connection connection(connection_, "test");
  JobStore store(connection);
  EXPECT_FALSE(store.frame("run1.0", 0, 1)) << "what is done is dropped";
}

TEST_F(Archives, PosesThatTheServerDoesNotTakeSaySo) {
  TempDir folder;
  const NatsServer small(folder.path(),
                         "max_payload: 2048\njetstream: {store_dir: \"" + (folder.path() / "js").string() + "\"}\n");
  connection_.servers = {small.url()};
  for (int i = 0; i < 20; ++i) archive_.files.push_back("/no/such/file");
  archive_.frames_per_job = 20;
  archive_.format = PoseFormat::kJsonl;
  submit_archive(connection_, archive_);
  const Process first({CYLPOSE_COMMAND, "worker", "--jobs", "--backend", "serial", "--server", small.url()},
                      folder_.path() / "worker.log");
  try {
    static_cast<void>(collected());
    ADD_FAILURE() << "not refused";
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), HasSubstr("fewer --job-frames"));
  }
  archive_.name = "run2";
  archive_.files.resize(200, "/no/such/file");
  archive_.frames_per_job = 200;
  EXPECT_THROW(submit_archive(connection_, archive_), Error);
}

TEST_F(Archives, JobsThatCannotBeReadSaySo) {
  make_frames(1);
  submit_archive(connection_, archive_);
  const Connection connection(connection_, "a stranger");
  JobStore(connection).put_job("run1.0", "{\"first\": 0}");
  const Process first = worker(0);
  try {
    static_cast<void>(collected());
    ADD_FAILURE() << "not refused";
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), HasSubstr("archive run1, job 0: the job cannot be read"));
  }
}

class BrokenBackend final : public Backend {
 public:
  [[nodiscard]] std::string_view name() const override { return "broken"; }
  [[nodiscard]] EdgeField detect(const ImageView&, const Roi&, std::span<const PartModel>,
                                 const DetectOptions&) override {
    throw Error(ErrorKind::kDevice, "the device is lost");
  }
};

TEST_F(Archives, AWorkerWhoseDeviceFailsLeavesItsJobToOthers) {
  make_frames(3);
  submit_archive(connection_, archive_);
  BrokenBackend broken;
  EXPECT_THROW(run_jobs(broken, connection_, [] { return false; }), Error);
  const Process second = worker(0);
  expect_rows(collected(), 3);
}

TEST_F(Archives, MaySubmittedAgainGoOnWhereTheyStopped) {
  make_frames(9);
  EXPECT_EQ(submit_archive(connection_, archive_), 3);
  const Process first = worker(0);
  expect_rows(collected(), 9);
  EXPECT_EQ(submit_archive(connection_, archive_), 3);
  expect_rows(collected(), 9);
  archive_.files.pop_back();
  EXPECT_THROW(submit_archive(connection_, archive_), Error) << "another archive of that name";
}

TEST_F(Archives, JobsThatCannotBeDoneSaySo) {
  make_frames(3);
  archive_.camera_yaml = "image_width: none\n";
  submit_archive(connection_, archive_);
  const Process first = worker(0);
  try {
    static_cast<void>(collected());
    ADD_FAILURE() << "not refused";
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::kInput);
    EXPECT_THAT(error.what(), HasSubstr("archive run1, job 0"));
  }
}

TEST_F(Archives, UnknownAndUnusableOnesAreRefused) {
  EXPECT_THROW(static_cast<void>(collected()), Error);
  EXPECT_THROW(submit_archive(connection_, archive_), Error) << "no frames";
  make_frames(1);
  archive_.name = "a.b";
  EXPECT_THROW(submit_archive(connection_, archive_), Error);
}

}  // namespace
}  // namespace cylpose::cluster
