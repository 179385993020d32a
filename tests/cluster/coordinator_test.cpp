// cluster = serial, bit for bit, and workers and coordinators understand each other.
#include <csignal>
#include <cylpose/cluster/nodes.hpp>
#include <cylpose/error.hpp>
#include <fstream>
#include <list>
#include <set>

#include "cluster_fixture.hpp"
#include "fake_node.hpp"
#include "wire_generated.h"

namespace cylpose::cluster {
namespace {

using ::cylpose::testing::Cluster;
using ::cylpose::testing::connection_to;
using ::cylpose::testing::eventually;
using ::cylpose::testing::FakeNode;
using ::cylpose::testing::four_parts;
using ::cylpose::testing::kPatience;
using ::cylpose::testing::NatsServer;
using ::cylpose::testing::Process;
using ::cylpose::testing::random_image;
using ::cylpose::testing::remote_coordinator;
using ::cylpose::testing::TestImage;
using ::cylpose::testing::TestWorker;
using std::chrono::milliseconds;
using ::testing::HasSubstr;

/// So slow that nodes are worth it.
class SlowBackend final : public Backend {
 public:
  [[nodiscard]] std::string_view name() const override { return "slow"; }
  [[nodiscard]] EdgeField detect(const ImageView& image, const Roi& search, std::span<const PartModel> parts,
                                 const DetectOptions& options) override {
    constexpr double kMicrosecondsPerPixel = 1;
    std::this_thread::sleep_for(
        std::chrono::microseconds(static_cast<std::int64_t>(kMicrosecondsPerPixel * search.width * search.height)));
    return serial_->detect(image, search, parts, options);
  }

 private:
  std::unique_ptr<Backend> serial_ = make_backend("serial");
};

TEST_F(Cluster, WithoutNodesTheLocalDeviceDoesEverything) {
  const auto sharing = coordinator(true);
  EXPECT_GT(expect_equal_frames(*sharing, 10), 100U);
  EXPECT_EQ(sharing->counters().frames, 10);
  EXPECT_EQ(sharing->counters().sent, 0);
  const auto remote = coordinator(false, milliseconds(20));
  EXPECT_GT(expect_equal_frames(*remote, 5), 100U);
}

TEST_F(Cluster, NodesAloneGiveTheSerialAnswer) {
  for (const std::size_t count : {1U, 3U, 8U}) {
    SCOPED_TRACE(count);
    std::list<TestWorker> workers;
    for (std::size_t i = 0; i < count; ++i) workers.emplace_back(server_.url());
    const auto cluster = coordinator(false, milliseconds(20'000), 16);
    ASSERT_TRUE(has_nodes(*cluster, count));
    EXPECT_GT(expect_equal_frames(*cluster, 30), 1000U);
    const ClusterCounters counters = cluster->counters();
    EXPECT_GT(counters.used, 60);
    EXPECT_TRUE(nearly_all_by_nodes(counters));
    EXPECT_EQ(counters.refused, 0);
  }
}

TEST_F(Cluster, NodesAndTheLocalDeviceWorkOnOneFrame) {
  const TestWorker worker(server_.url());
  const auto cluster = coordinator(true, milliseconds(2000), 0, std::make_unique<SlowBackend>());
  ASSERT_TRUE(has_nodes(*cluster, 1));
  const TestImage image = random_image(300, 200, random_);
  const Roi all = image.view().bounds();
  const EdgeField expected = make_backend("serial")->detect(image.view(), all, four_parts(), {});
  ASSERT_TRUE(eventually([&] {
    const EdgeField actual = cluster->detect(image.view(), all, four_parts(), {});
    for (std::size_t part = 0; part < 4; ++part) EXPECT_EQ(actual.parts[part].edges, expected.parts[part].edges);
    return cluster->counters().shared_frames >= 3 || HasFailure();
  }));
  EXPECT_GT(cluster->counters().used, 0);
}

TEST_F(Cluster, SeveralThreadsShareTheNodes) {
  std::list<TestWorker> workers;
  for (int i = 0; i < 2; ++i) workers.emplace_back(server_.url());
  const auto cluster = coordinator(false, milliseconds(20'000), 40);
  ASSERT_TRUE(has_nodes(*cluster, 2));
  const std::unique_ptr<Backend> serial = make_backend("serial");
  std::vector<std::jthread> threads;
  for (unsigned seed = 0; seed < 4; ++seed) {
    threads.emplace_back([&, seed] {
      std::mt19937 random(seed);
      for (int i = 0; i < 10; ++i) {
        const TestImage image = random_image(120, 90, random);
        const EdgeField expected = serial->detect(image.view(), image.view().bounds(), four_parts(), {});
        const EdgeField actual = cluster->detect(image.view(), image.view().bounds(), four_parts(), {});
        for (std::size_t part = 0; part < 4; ++part) EXPECT_EQ(actual.parts[part].edges, expected.parts[part].edges);
      }
    });
  }
  threads.clear();
  EXPECT_TRUE(nearly_all_by_nodes(cluster->counters()));
}

TEST_F(Cluster, FramesThatAreUnderWayAtOnceAreCutIntoFewerTiles) {
  std::mutex mutex;
  std::vector<FakeNode::Asked> kept;
  std::set<int> rows;
  std::list<FakeNode> nodes;
  for (int i = 0; i < 4; ++i) {
    nodes.emplace_back(server_.url(), [&](const Connection&, const FakeNode::Asked& asked) {
      const Message message = decode(asked.message);
      const auto& tile = std::get<Tile>(message.body);
      const std::scoped_lock lock(mutex);
      kept.push_back(asked);
      rows.insert(tile.rows.end - tile.rows.first);
    });
  }
  const auto cluster = coordinator(false, milliseconds(20'000));
  ASSERT_TRUE(has_nodes(*cluster, nodes.size()));
  const TestImage image = random_image(160, 192, random_);
  std::vector<std::jthread> frames;
  for (const int nodes_for_a_frame : {4, 2, 1}) {
    frames.emplace_back(
        [&] { static_cast<void>(cluster->detect(image.view(), image.view().bounds(), four_parts(), {})); });
    EXPECT_TRUE(eventually([&] {
      const std::scoped_lock lock(mutex);
      return rows.contains(192 / nodes_for_a_frame);
    }));
  }
  const std::scoped_lock lock(mutex);
  for (const FakeNode::Asked& asked : kept) {
    FakeNode::publish(nodes.front().connection(), asked.reply, FakeNode::honest(asked));
  }
}

TEST_F(Cluster, NodesJoinAndLeaveAtAnyTime) {
  const auto cluster = coordinator(false, milliseconds(2000), 16);
  std::list<TestWorker> workers;
  std::size_t edges = 0;
  for (int turn = 0; turn < 6; ++turn) {
    workers.emplace_back(server_.url());
    ASSERT_TRUE(has_nodes(*cluster, 1));
    edges += expect_equal_frames(*cluster, 3);
    std::jthread leaving([&] { workers.pop_front(); });
    edges += expect_equal_frames(*cluster, 3);
    leaving.join();
    ASSERT_TRUE(has_nodes(*cluster, 0));
  }
  EXPECT_GT(edges, 1000U);
  EXPECT_GT(cluster->counters().used, 20);
}

TEST_F(Cluster, AnotherVersionIsRefusedWithAWordToBothSides) {
  std::string told;
  std::mutex mutex;
  const auto other_kernels = [](const std::string& node) {
    flatbuffers::FlatBufferBuilder builder;
    const auto name = builder.CreateString(node);
    const auto hello = wire::CreateHello(builder, name, 2, 1.0F);
    const auto kernels = builder.CreateString("00112233445566778899");
    builder.Finish(wire::CreateMessage(builder, kProtocol, kernels, wire::Body_Hello, hello.Union()),
                   wire::MessageIdentifier());
    return FakeNode::Bytes(builder.GetBufferPointer(), builder.GetBufferPointer() + builder.GetSize());
  };
  const FakeNode old(
      server_.url(),
      [&](const Connection&, const FakeNode::Asked& asked) {
        const std::scoped_lock lock(mutex);
        told = std::get<Refusal>(decode(asked.message).body).reason;
      },
      other_kernels);
  const auto cluster = coordinator(true);
  EXPECT_TRUE(eventually([&] { return events().find("has the kernels 001122334455") != std::string::npos; }));
  EXPECT_TRUE(eventually([&] {
    const std::scoped_lock lock(mutex);
    return told.find("has the kernels 001122334455") != std::string::npos;
  }));
  EXPECT_TRUE(cluster->nodes().empty());
}

TEST_F(Cluster, ARealWorkerSaysThatItWasRefused) {
  const TestWorker worker(server_.url());
  const ConnectionOptions options = connection_to(server_.url());
  std::vector<NodeReport> nodes;
  ASSERT_TRUE(eventually([&] { return !(nodes = list_nodes(options, milliseconds(100))).empty(); }));
  const Connection connection(options, "a coordinator of another version");
  const Buffer refusal = encode(Refusal{"node has the wrong kernels"});
  connection.publish("cylpose.tile." + nodes[0].name + "." + nodes[0].id, {refusal.data(), refusal.size()});
  EXPECT_TRUE(eventually([&] { return worker.events().find("refused: node has the wrong") != std::string::npos; }));
}

TEST_F(Cluster, WorkersAnswerWhatTheyCannotDo) {
  const TestWorker worker(server_.url());
  const ConnectionOptions options = connection_to(server_.url());
  std::vector<NodeReport> nodes;
  ASSERT_TRUE(eventually([&] { return !(nodes = list_nodes(options, milliseconds(100))).empty(); }));
  const Connection connection(options, "a stranger");
  const NatsSubscription answers = connection.subscribe("answers.*");
  const std::string garbage = "garbage";
  connection.publish("cylpose.tile." + nodes[0].name + "." + nodes[0].id,
                     {reinterpret_cast<const std::uint8_t*>(garbage.data()), garbage.size()}, "answers.17");
  const NatsMessage answer = next_message(answers, kPatience);
  ASSERT_NE(answer, nullptr);
  const Message read = decode(data_of(answer));
  EXPECT_EQ(std::get<TileResult>(read.body).id, 17U);
  EXPECT_THAT(std::get<TileResult>(read.body).error, HasSubstr("none of cylpose"));
  // A busy node may be late with its statistics.
  EXPECT_TRUE(eventually([&] {
    nodes = list_nodes(options, milliseconds(200));
    return nodes.size() == 1 && nodes[0].failed == 1;
  }));
}

TEST_F(Cluster, NodesAreListedByTheServicesConvention) {
  const TestWorker first(server_.url(), "first");
  const TestWorker second(server_.url(), "second");
  const ConnectionOptions options = connection_to(server_.url());
  std::vector<NodeReport> nodes;
  ASSERT_TRUE(eventually([&] { return (nodes = list_nodes(options, milliseconds(200))).size() == 2; }));
  EXPECT_EQ(nodes[0].name, "first");
  EXPECT_EQ(nodes[1].name, "second");
  EXPECT_EQ(nodes[0].device, "a test");
  EXPECT_TRUE(nodes[0].usable);

  const Connection connection(options, "a tool");
  const NatsSubscription answers = connection.subscribe("tool.inbox");
  connection.publish("$SRV.INFO.cylpose." + nodes[1].id, {}, "tool.inbox");
  const NatsMessage answer = next_message(answers, kPatience);
  ASSERT_NE(answer, nullptr);
  const auto data = data_of(answer);
  const std::string json(data.begin(), data.end());
  EXPECT_THAT(json, HasSubstr(R"("type":"io.nats.micro.v1.info_response")"));
  EXPECT_THAT(json, HasSubstr(R"("subject":"cylpose.tile.second.)"));
  EXPECT_EQ(next_message(answers, milliseconds(100)), nullptr) << "only the one asked answers";
}

TEST_F(Cluster, TilesKeepToTheServersLargestMessage) {
  TempDir folder;
  const NatsServer small(folder.path(), "max_payload: 40000\n");
  const TestWorker worker(small.url());
  const auto cluster = remote_coordinator(connection_to(small.url()));
  ASSERT_TRUE(has_nodes(*cluster, 1));
  TestImage image(300, 200);
  for (int y = 30; y < 170; ++y) {
    for (int x = 100; x < 150; ++x) image.pixel(x, y)[2] = 200;
  }
  const Roi all = image.view().bounds();
  const EdgeField expected = make_backend("serial")->detect(image.view(), all, four_parts(), {});
  const EdgeField actual = cluster->detect(image.view(), all, four_parts(), {});
  EXPECT_GT(expected.parts[0].edges.size(), 300U);
  EXPECT_EQ(actual.parts[0].edges, expected.parts[0].edges);
  EXPECT_GT(cluster->counters().used, 5);
  EXPECT_TRUE(nearly_all_by_nodes(cluster->counters()));
}

// Noise has so many edges that the result does not fit though the tile does.
TEST_F(Cluster, ResultsTooLargeForTheServerAreMadeLocally) {
  TempDir folder;
  const NatsServer small(folder.path(), "max_payload: 20000\n");
  const TestWorker worker(small.url());
  const auto cluster = remote_coordinator(connection_to(small.url()));
  ASSERT_TRUE(has_nodes(*cluster, 1));
  EXPECT_GT(expect_equal_frames(*cluster, 9), 100U);
  EXPECT_GT(cluster->counters().taken_back, 0);
}

TEST_F(Cluster, TheCommandDrainsOnSigterm) {
  Process worker({CYLPOSE_COMMAND, "worker", "--backend", "serial", "--name", "lab", "--server", server_.url()},
                 folder_.path() / "worker.log");
  const auto cluster = coordinator(false, milliseconds(20'000), 16);
  ASSERT_TRUE(has_nodes(*cluster, 1));
  EXPECT_THAT(cluster->nodes()[0].node, ::testing::StartsWith("lab."));
  EXPECT_GT(expect_equal_frames(*cluster, 3), 0U);
  worker.send(SIGTERM);
  EXPECT_EQ(worker.wait(), 0);
  EXPECT_TRUE(cluster->nodes().empty() || has_nodes(*cluster, 0));
  EXPECT_TRUE(nearly_all_by_nodes(cluster->counters()));
}

// Pages that the system had to give a process, from /proc/PID/stat.
std::int64_t page_faults(int process) {
  std::ifstream file("/proc/" + std::to_string(process) + "/stat");
  std::string text;
  std::getline(file, text, ')');
  constexpr int kMinorFaults = 10 - 2;
  for (int i = 0; i < kMinorFaults; ++i) file >> text;
  return std::stoll(text);
}

TEST_F(Cluster, AWorkerKeepsItsMemoryFromTileToTile) {
#if defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
  GTEST_SKIP() << "sanitizers have an allocator of their own";
#endif
#endif
  const Process worker({CYLPOSE_COMMAND, "worker", "--backend", "serial", "--server", server_.url()},
                       folder_.path() / "worker.log");
  const auto cluster = coordinator(false, milliseconds(20'000));
  ASSERT_TRUE(has_nodes(*cluster, 1));
  const TestImage image(640, 400);
  const auto tiles = [&](int count) {
    for (int i = 0; i < count; ++i) {
      static_cast<void>(cluster->detect(image.view(), image.view().bounds(), four_parts(), {}));
    }
  };
  tiles(20);
  const std::int64_t before = page_faults(worker.id());
  tiles(20);
  const std::int64_t image_pages = 640 * 400 * 3 / 4096;
  EXPECT_LT(page_faults(worker.id()) - before, 20 * image_pages);
}

TEST_F(Cluster, OptionsThatCannotWorkAreRefused) {
  ClusterOptions options;
  EXPECT_THROW(static_cast<void>(make_cluster_backend(make_backend("serial"), options)), Error);
  options.connection.servers = {"no://address"};
  EXPECT_THROW(static_cast<void>(make_cluster_backend(make_backend("serial"), options)), Error);
  options.connection.servers = {server_.url()};
  EXPECT_THROW(static_cast<void>(make_cluster_backend(nullptr, options)), Error);
  options.deadline = milliseconds(0);
  EXPECT_THROW(static_cast<void>(make_cluster_backend(make_backend("serial"), options)), Error);
  WorkerOptions worker;
  worker.connection.servers = {server_.url()};
  const std::unique_ptr<Backend> serial = make_backend("serial");
  for (const char* name : {"", "a b", "a.b", "*", ">"}) {
    worker.name = name;
    EXPECT_THROW(run_worker(*serial, worker, [] { return true; }), Error) << name;
  }
}

}  // namespace
}  // namespace cylpose::cluster
