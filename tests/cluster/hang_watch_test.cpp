// Devices that hang are noticed, and the worker ends.
#include <atomic>
#include <cylpose/cluster/hang_watch.hpp>
#include <cylpose/error.hpp>

#include "cluster_fixture.hpp"

namespace cylpose::cluster {
namespace {

using ::cylpose::testing::Cluster;
using ::cylpose::testing::eventually;
using ::cylpose::testing::Process;
using ::cylpose::testing::random_image;
using ::cylpose::testing::TestImage;
using std::chrono::milliseconds;
using ::testing::HasSubstr;

/// Hangs, when it is told to, until it is told not to.
class HangingBackend final : public Backend {
 public:
  explicit HangingBackend(std::atomic<bool>& hangs) : hangs_(hangs) {}
  [[nodiscard]] std::string_view name() const override { return "hanging"; }
  [[nodiscard]] EdgeField detect(const ImageView& image, const Roi& search, std::span<const PartModel> parts,
                                 const DetectOptions& options) override {
    hangs_.wait(true);
    return serial_->detect(image, search, parts, options);
  }

 private:
  std::atomic<bool>& hangs_;
  std::unique_ptr<Backend> serial_ = make_backend("serial");
};

TEST(HangWatch, TellsOfADetectionThatDoesNotEnd) {
  std::atomic<bool> hangs = false;
  std::atomic<int> told = 0;
  std::string what;
  const auto backend =
      watched(std::make_unique<HangingBackend>(hangs), milliseconds(50), [&](const std::string& message) {
        what = message;
        ++told;
      });
  std::mt19937 random(3);
  const TestImage image = random_image(40, 30, random);
  const auto detect = [&] {
    return backend->detect(image.view(), image.view().bounds(), testing::four_parts(), {}).parts.size();
  };
  EXPECT_EQ(backend->name(), "hanging");
  EXPECT_EQ(detect(), 4U);
  std::this_thread::sleep_for(milliseconds(100));
  EXPECT_EQ(told, 0) << "idle is not hanging";
  hangs = true;
  std::jthread detecting([&] { detect(); });
  EXPECT_TRUE(eventually([&] { return told == 1; }));
  EXPECT_THAT(what, HasSubstr("hangs: a detection has taken more than 50 ms"));
  hangs = false;
  hangs.notify_all();
}

TEST(HangWatch, RefusesATimeThatIsNone) {
  EXPECT_THROW(static_cast<void>(watched(make_backend("serial"), milliseconds(0), {})), Error);
}

TEST_F(Cluster, AWorkerThatHangsEndsItself) {
  // No device does a tile of that size in a millisecond on one thread without vectors.
  Process worker({CYLPOSE_COMMAND, "worker", "--backend", "serial", "--hang", "1", "--server", server_.url()},
                 folder_.path() / "worker.log");
  const auto cluster = coordinator(false, milliseconds(1000));
  // Where the machine is slow it ends itself before it says hello, by the detection that tells its rate.
  ASSERT_TRUE(eventually([&] { return !cluster->nodes().empty() || worker.has_ended(); }));
  const TestImage image = random_image(600, 400, random_);
  const EdgeField expected =
      make_backend("serial")->detect(image.view(), image.view().bounds(), testing::four_parts(), {});
  EXPECT_TRUE(eventually([&] {
    const EdgeField actual = cluster->detect(image.view(), image.view().bounds(), testing::four_parts(), {});
    EXPECT_EQ(actual.parts[0].edges, expected.parts[0].edges);
    return cluster->nodes().empty() || HasFailure();
  }));
  EXPECT_EQ(worker.wait(), 4);
  EXPECT_THAT(worker.output(), HasSubstr("the device hangs"));
}

}  // namespace
}  // namespace cylpose::cluster
