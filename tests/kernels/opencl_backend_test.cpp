#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <cstdlib>
#include <cylpose/error.hpp>
#include <deque>
#include <mutex>
#include <random>
#include <string>
#include <thread>
#include <vector>

#include "comparison.hpp"
#include "host/test_images.hpp"

namespace cylpose {
namespace {

using ::testing::AllOf;
using testing::expect_equal;
using testing::four_parts;
using ::testing::HasSubstr;
using testing::random_image;
using testing::TestImage;

class DeviceVariable {
 public:
  explicit DeviceVariable(const char* value) {
    const char* before = std::getenv("CYLPOSE_DEVICE");
    had_ = before != nullptr;
    if (had_) before_ = before;
    ::setenv("CYLPOSE_DEVICE", value, 1);
  }
  ~DeviceVariable() {
    if (had_) {
      ::setenv("CYLPOSE_DEVICE", before_.c_str(), 1);
    } else {
      ::unsetenv("CYLPOSE_DEVICE");
    }
  }
  DeviceVariable(const DeviceVariable&) = delete;
  DeviceVariable& operator=(const DeviceVariable&) = delete;

 private:
  bool had_;
  std::string before_;
};

OpenclOptions on(const std::string& device) {
  OpenclOptions options;
  options.device = device;
  return options;
}

template <typename Function>
std::string error_of(ErrorKind kind, Function function) {
  try {
    function();
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), kind);
    return error.what();
  }
  return "no error";
}

TEST(OpenclDevices, AreListedWithWhatMatters) {
  const std::vector<OpenclDevice> devices = opencl_devices();
  ASSERT_FALSE(devices.empty()) << "the tests of the kernels need an OpenCL device: pocl-opencl-icd";
  for (std::size_t i = 0; i < devices.size(); ++i) {
    EXPECT_EQ(devices[i].index, static_cast<int>(i));
    EXPECT_FALSE(devices[i].name.empty());
    EXPECT_FALSE(devices[i].platform.empty());
    EXPECT_FALSE(devices[i].driver_version.empty());
    EXPECT_GT(devices[i].compute_units, 0);
    EXPECT_GT(devices[i].memory_bytes, 0U);
  }
}

TEST(OpenclDevices, AreChosenByIndexTypeAndPartOfTheName) {
  for (const OpenclDevice& device : opencl_devices()) {
    if (!device.unusable.empty()) continue;
    const auto chosen = [](const std::string& wanted) {
      const auto backend = make_opencl_backend(on(wanted));
      EXPECT_EQ(backend->name(), "opencl");
      EXPECT_EQ(backend->devices().size(), 1U);
      return backend->devices().at(0);
    };
    EXPECT_EQ(chosen(std::to_string(device.index)).index, device.index);
    EXPECT_EQ(chosen(device.type).type, device.type);
    std::string shouted = device.name;
    std::ranges::transform(shouted, shouted.begin(),
                           [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
    EXPECT_EQ(chosen(shouted).name, device.name);
    EXPECT_EQ(chosen(device.platform.substr(1)).platform, device.platform);
  }
}

TEST(OpenclDevices, OneThatDoesNotExistIsAnsweredWithThoseThatDo) {
  const std::string name = opencl_devices().at(0).name;
  for (const std::string wanted : {"99", "-1", "abacus", "custom"}) {
    EXPECT_THAT(error_of(ErrorKind::kInput, [&] { static_cast<void>(make_opencl_backend(on(wanted))); }),
                AllOf(HasSubstr("'" + wanted + "'"), HasSubstr(name)));
  }
}

TEST(OpenclDevices, TheEnvironmentDecidesWhereNoOptionDoes) {
  const DeviceVariable variable("abacus");
  EXPECT_THAT(error_of(ErrorKind::kInput, [] { static_cast<void>(make_backend("opencl")); }),
              AllOf(HasSubstr("'abacus'"), HasSubstr("CYLPOSE_DEVICE")));
  EXPECT_EQ(make_opencl_backend(on("0"))->devices().at(0).index, 0);
}

TEST(OpenclDevices, CanBeSeveralAndDivided) {
  EXPECT_EQ(make_opencl_backend(on("0,0"))->devices().size(), 2U);
  const OpenclDevice whole = opencl_devices().at(0);
  if (whole.sub_devices >= 2 && whole.compute_units % 2 == 0) {
    const auto halves = make_opencl_backend(on("0/2"))->devices();
    ASSERT_EQ(halves.size(), 2U);
    EXPECT_EQ(halves[0].compute_units, whole.compute_units / 2);
    EXPECT_NE(halves[0].name, halves[1].name);
    std::mt19937 random(3);
    const TestImage image = random_image(640, 400, random);
    OpenclOptions options = on("0/2");
    options.strip_rows = 100;
    expect_equal(*make_opencl_backend(options), image.view(), image.view().bounds(), four_parts());
  }
  EXPECT_THAT(error_of(ErrorKind::kInput, [] { static_cast<void>(make_opencl_backend(on("0/1000"))); }),
              HasSubstr("cannot be divided into 1000 parts"));
  for (const std::string wrong : {"0/", "0/x", "0/0", "0/-1", ",", "/2"}) {
    EXPECT_THAT(error_of(ErrorKind::kInput, [&] { static_cast<void>(make_opencl_backend(on(wrong))); }),
                HasSubstr("OpenCL device"))
        << wrong;
  }
}

TEST(OpenclBackend, SharesALargeFrameByMeasuredSpeed) {
  std::mt19937 random(4);
  const TestImage image = random_image(1280, 1000, random);
  const auto backend = make_opencl_backend(on("0,0"));
  for (int i = 0; i < 4; ++i) expect_equal(*backend, image.view(), image.view().bounds(), four_parts());
}

TEST(OpenclBackend, IsRegisteredAndRunsOnTheDeviceAskedFor) {
  const DeviceVariable variable("0");
  const std::unique_ptr<Backend> made = make_backend("opencl");
  EXPECT_EQ(made->name(), "opencl");
  auto* backend = dynamic_cast<OpenclBackend*>(made.get());
  ASSERT_NE(backend, nullptr);
  EXPECT_EQ(backend->devices().at(0).name, opencl_devices().at(0).name);
}

TEST(OpenclBackend, RefusesUnusableOptionsAndImages) {
  OpenclOptions options;
  options.timeout = std::chrono::milliseconds(0);
  EXPECT_THAT(error_of(ErrorKind::kInput, [&] { static_cast<void>(make_opencl_backend(options)); }),
              HasSubstr("timeout"));
  const auto backend = make_opencl_backend();
  const ImageView none;
  EXPECT_THAT(error_of(ErrorKind::kInput, [&] { static_cast<void>(backend->detect(none, {}, four_parts(), {})); }),
              HasSubstr("image is empty"));
}

TEST(OpenclBackend, NothingToSearchGivesNothing) {
  std::mt19937 random(1);
  const TestImage image = random_image(40, 30, random);
  const auto backend = make_opencl_backend();
  expect_equal(*backend, image.view(), {100, 100, 20, 20}, four_parts());
  expect_equal(*backend, image.view(), {}, four_parts());
  EXPECT_TRUE(backend->detect(image.view(), image.view().bounds(), {}, {}).parts.empty());
}

TEST(OpenclBackend, TimesItsKernelsOnRequest) {
  std::mt19937 random(2);
  const TestImage image = random_image(320, 200, random);
  OpenclOptions options;
  options.profile = true;
  const EdgeField field = make_opencl_backend(options)->detect(image.view(), image.view().bounds(), four_parts(), {});
  std::vector<std::string> stages;
  for (const StageTime& time : field.times) {
    stages.emplace_back(time.stage);
    EXPECT_GT(time.milliseconds, 0);
    EXPECT_LT(time.milliseconds, 1000);
  }
  for (const char* stage : {"gate", "opening", "edges", "locate"}) EXPECT_THAT(stages, ::testing::Contains(stage));
}

TEST(OpenclBackend, ADeviceThatIsLateIsAnError) {
  // Never freed, not even at exit: the device goes on reading it.
  static const auto& pixels = *new std::vector<std::uint8_t>(std::size_t{3} * 12000 * 12000, 77);
  const ImageView image{pixels.data(), 12000, 12000, std::ptrdiff_t{3} * 12000, PixelFormat::kBgr8};
  OpenclOptions options;
  options.timeout = std::chrono::milliseconds(1);
  const auto impatient = make_opencl_backend(options);
  // The first run may compile, and has more time.
  EXPECT_EQ(impatient->detect(image, {0, 0, 64, 64}, four_parts(), {}).parts.size(), four_parts().size());
  EXPECT_THAT(error_of(ErrorKind::kDevice,
                       [&] { static_cast<void>(impatient->detect(image, image.bounds(), four_parts(), {})); }),
              AllOf(HasSubstr("did not answer within 1 ms"), HasSubstr(impatient->devices().at(0).name)));
}

// Hands over to a queue, as a program's own threads would take it.
class EndQueue {
 public:
  [[nodiscard]] OnDetected entrance() {
    return [this](std::shared_ptr<DetectionEnd> end) {
      const std::scoped_lock lock(mutex_);
      ends_.push_back(std::move(end));
      changed_.notify_one();
    };
  }

  [[nodiscard]] std::shared_ptr<DetectionEnd> next() {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [this] { return !ends_.empty(); });
    std::shared_ptr<DetectionEnd> end = std::move(ends_.front());
    ends_.pop_front();
    return end;
  }

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<std::shared_ptr<DetectionEnd>> ends_;
};

TEST(OpenclBackend, ManyFramesUnderWayWithoutAWaitingThreadGiveTheAnswerOfSerial) {
  const auto serial = make_backend("serial");
  for (const std::string device : {"0", "0,0"}) {  // one strip, and several
    OpenclOptions options = on(device);
    options.strip_rows = device == "0" ? 0 : 30;
    const auto backend = make_opencl_backend(options);
    std::mt19937 random(6);
    std::vector<TestImage> images;
    for (int i = 0; i < 12; ++i) images.push_back(random_image(200, 100, random));
    std::size_t edges = 0;
    for (int round = 0; round < 5; ++round) {
      std::vector<EndQueue> queues(images.size());
      for (std::size_t i = 0; i < images.size(); ++i) {
        backend->detect_async({images[i].view(), images[i].view().bounds(), four_parts(), {}}, queues[i].entrance());
      }
      for (std::size_t i = 0; i < images.size(); ++i) {
        const EdgeField field = queues[i].next()->field();
        const EdgeField expected = serial->detect(images[i].view(), images[i].view().bounds(), four_parts(), {});
        EXPECT_EQ(field.searched, expected.searched);
        ASSERT_EQ(field.parts.size(), four_parts().size());
        for (std::size_t part = 0; part < field.parts.size(); ++part) {
          EXPECT_EQ(field.parts[part].region, expected.parts[part].region);
          EXPECT_EQ(field.parts[part].edges, expected.parts[part].edges);
          edges += field.parts[part].edges.size();
        }
      }
    }
    EXPECT_GT(edges, 10000U) << "there must be something to compare";
  }
}

TEST(OpenclBackend, AnEndThatNobodyWantsLeavesTheImageAlone) {
  const auto backend = make_opencl_backend();
  std::mt19937 random(7);
  for (int i = 0; i < 20; ++i) {
    const TestImage image = random_image(300, 200, random);
    EndQueue queue;
    backend->detect_async({image.view(), image.view().bounds(), four_parts(), {}}, queue.entrance());
    queue.next().reset();
  }
  const TestImage image = random_image(300, 200, random);
  expect_equal(*backend, image.view(), image.view().bounds(), four_parts());
}

TEST(OpenclBackend, WithoutAWaitingThreadFailuresComeOutOfTheEnd) {
  const auto backend = make_opencl_backend();
  EndQueue queue;
  backend->detect_async({{}, {}, four_parts(), {}}, queue.entrance());
  EXPECT_THAT(error_of(ErrorKind::kInput, [&] { static_cast<void>(queue.next()->field()); }),
              HasSubstr("image is empty"));
}

TEST(OpenclBackend, TheWatchdogEndsWhatNoThreadWaitsFor) {
  // Never freed, not even at exit: the device goes on reading it.
  static const auto& pixels = *new std::vector<std::uint8_t>(std::size_t{3} * 12000 * 12000, 77);
  const ImageView image{pixels.data(), 12000, 12000, std::ptrdiff_t{3} * 12000, PixelFormat::kBgr8};
  OpenclOptions options;
  options.timeout = std::chrono::milliseconds(1);
  const auto impatient = make_opencl_backend(options);
  // The first run may compile, and has more time.
  EXPECT_EQ(impatient->detect(image, {0, 0, 64, 64}, four_parts(), {}).parts.size(), four_parts().size());
  EndQueue queue;
  impatient->detect_async({image, image.bounds(), four_parts(), {}}, queue.entrance());
  const std::shared_ptr<DetectionEnd> end = queue.next();
  EXPECT_THAT(error_of(ErrorKind::kDevice, [&] { static_cast<void>(end->field()); }),
              HasSubstr("did not answer within 1 ms"));
}

TEST(OpenclBackend, ServesSeveralThreadsAtOnce) {
  const auto backend = make_opencl_backend();
  const auto work = [&](unsigned seed) {
    std::mt19937 random(seed);
    for (int i = 0; i < 15; ++i) {
      const TestImage image = random_image(60 + static_cast<int>(seed) * 37, 40 + i, random,
                                           i % 3 == 0 ? PixelFormat::kRgb8 : PixelFormat::kBgr8);
      expect_equal(*backend, image.view(), image.view().bounds(), four_parts());
    }
  };
  std::vector<std::thread> threads;
  for (unsigned seed = 0; seed < 4; ++seed) threads.emplace_back(work, seed);
  for (std::thread& thread : threads) thread.join();
}

}  // namespace
}  // namespace cylpose
