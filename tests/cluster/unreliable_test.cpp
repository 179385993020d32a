// cluster = serial, bit for bit, whatever nodes, servers, networks and strangers do.
#include <csignal>
#include <cylpose/error.hpp>
#include <deque>
#include <list>

#include "cluster_fixture.hpp"
#include "fake_node.hpp"
#include "throttled_link.hpp"

namespace cylpose::cluster {
namespace {

using ::cylpose::testing::Cluster;
using ::cylpose::testing::connection_to;
using ::cylpose::testing::eventually;
using ::cylpose::testing::FakeNode;
using ::cylpose::testing::NatsServer;
using ::cylpose::testing::Port;
using ::cylpose::testing::Process;
using ::cylpose::testing::remote_coordinator;
using ::cylpose::testing::TestWorker;
using ::cylpose::testing::ThrottledLink;
using std::chrono::milliseconds;
using ::testing::HasSubstr;

TEST_F(Cluster, SilentNodesCostTimeAndNothingElse) {
  const FakeNode silent(server_.url(), [](const Connection&, const FakeNode::Asked&) {});
  const auto cluster = coordinator(false, milliseconds(30), 32);
  ASSERT_TRUE(has_nodes(*cluster, 1));
  EXPECT_GT(expect_equal_frames(*cluster, 6), 100U);
  EXPECT_GT(cluster->counters().taken_back, 0);
  EXPECT_EQ(cluster->counters().used, 0);
}

TEST_F(Cluster, LateResultsChangeNothing) {
  std::deque<FakeNode::Asked> kept;
  const FakeNode slow(server_.url(), [&kept](const Connection& connection, const FakeNode::Asked& asked) {
    kept.push_back(asked);
    constexpr std::size_t kBehind = 3;
    if (kept.size() <= kBehind) return;
    FakeNode::publish(connection, kept.front().reply, FakeNode::honest(kept.front()));
    kept.pop_front();
  });
  const auto cluster = coordinator(false, milliseconds(20), 64);
  ASSERT_TRUE(has_nodes(*cluster, 1));
  EXPECT_GT(expect_equal_frames(*cluster, 25), 1000U);
  EXPECT_TRUE(eventually([&] { return cluster->counters().late > 0; }));
}

TEST_F(Cluster, DuplicatedAndReorderedResultsChangeNothing) {
  std::vector<FakeNode::Asked> kept;
  const FakeNode jumbling(server_.url(), [&kept](const Connection& connection, const FakeNode::Asked& asked) {
    kept.push_back(asked);
    constexpr std::size_t kTogether = 3;
    if (kept.size() < kTogether) return;
    for (int twice = 0; twice < 2; ++twice) {
      for (auto one = kept.rbegin(); one != kept.rend(); ++one) {
        FakeNode::publish(connection, one->reply, FakeNode::honest(*one));
      }
    }
    kept.clear();
  });
  const auto cluster = coordinator(false, milliseconds(30), 16);
  ASSERT_TRUE(has_nodes(*cluster, 1));
  EXPECT_GT(expect_equal_frames(*cluster, 30), 1000U);
  EXPECT_TRUE(eventually([&] {
    expect_equal_frames(*cluster, 1);
    return cluster->counters().used > 10 || HasFailure();
  }));
  EXPECT_TRUE(eventually([&] { return cluster->counters().refused > 10; })) << "duplicates are of unknown tiles";
}

TEST_F(Cluster, ForgedResultsChangeNothing) {
  int turn = 0;
  const FakeNode forger(server_.url(), [&turn](const Connection& connection, const FakeNode::Asked& asked) {
    TileResult result = FakeNode::honest(asked);
    const std::string session = asked.reply.substr(0, asked.reply.rfind('.') + 1);
    switch (turn++ % 8) {
      case 0:  // garbage
        connection.publish(asked.reply, std::string("no message of ours"));
        return;
      case 1:  // of another tile
        ++result.id;
        FakeNode::publish(connection, asked.reply, result);
        return;
      case 2:  // of a tile that does not exist
        result.id += 1000;
        FakeNode::publish(connection, session + std::to_string(result.id), result);
        return;
      case 3:  // edges elsewhere
        result.parts[0].edges.insert(result.parts[0].edges.begin(), {-1, 0, 1, 1, 0, EdgeStrength::kStrong});
        FakeNode::publish(connection, asked.reply, result);
        return;
      case 4:  // a mask larger than the tile
        result.parts[0].region.m00 = 1 << 30;
        FakeNode::publish(connection, asked.reply, result);
        return;
      case 5:  // more parts than asked for
        result.parts.push_back(result.parts[0]);
        FakeNode::publish(connection, asked.reply, result);
        return;
      case 6:  // a subject without a number
        FakeNode::publish(connection, session + "x", result);
        return;
      default:  // truncated
        const Buffer whole = encode(result);
        connection.publish(asked.reply, std::span<const std::uint8_t>(whole.data(), whole.size() / 2));
        return;
    }
  });
  const auto cluster = coordinator(false, milliseconds(30), 16);
  ASSERT_TRUE(has_nodes(*cluster, 1));
  EXPECT_GT(expect_equal_frames(*cluster, 20), 1000U);
  EXPECT_TRUE(eventually([&] {
    expect_equal_frames(*cluster, 1);
    return cluster->counters().refused > 16 || HasFailure();
  }));
  EXPECT_EQ(cluster->counters().used, 0);
}

TEST_F(Cluster, ResultsNobodyAskedForChangeNothing) {
  const TestWorker worker(server_.url());
  const auto cluster = coordinator(false, milliseconds(5000), 32);
  ASSERT_TRUE(has_nodes(*cluster, 1));
  // A stranger who does not know the session.
  const FakeNode stranger(
      server_.url(),
      [](const Connection& connection, const FakeNode::Asked&) {
        FakeNode::publish(connection, "cylpose.result.0123456789abcdef01234567.1", TileResult{1, 0, {}, {}});
      },
      [](const std::string&) {
        return FakeNode::Bytes{1, 2, 3};
      });
  EXPECT_GT(expect_equal_frames(*cluster, 10), 100U);
  EXPECT_TRUE(has_nodes(*cluster, 1)) << "a Hello that cannot be read makes no node";
  EXPECT_TRUE(eventually([&] { return cluster->counters().refused > 0; }));
}

TEST_F(Cluster, KilledWorkersLoseNoFrame) {
  const auto start = [this](int i) {
    return Process({CYLPOSE_COMMAND, "worker", "--backend", "serial", "--server", server_.url()},
                   folder_.path() / ("worker" + std::to_string(i) + ".log"));
  };
  std::vector<Process> workers;
  for (int i = 0; i < 3; ++i) workers.push_back(start(i));
  const auto cluster = coordinator(false, milliseconds(100), 16);
  ASSERT_TRUE(has_nodes(*cluster, 3));
  std::size_t edges = 0;
  for (int kill = 0; kill < 12; ++kill) {
    std::jthread killer([&] {
      workers[static_cast<std::size_t>(kill % 3)].kill();
      workers[static_cast<std::size_t>(kill % 3)] = start(kill % 3);
    });
    edges += expect_equal_frames(*cluster, 5);
  }
  EXPECT_GT(edges, 1000U);
  EXPECT_TRUE(eventually([&] {
    expect_equal_frames(*cluster, 1);
    return cluster->counters().used > 0 || HasFailure();
  }));
}

TEST_F(Cluster, AServerThatDiesAndComesBackLosesNoFrame) {
  const TestWorker worker(server_.url());
  const auto cluster = coordinator(false, milliseconds(100), 16);
  ASSERT_TRUE(has_nodes(*cluster, 1));
  for (int kill = 0; kill < 3; ++kill) {
    std::jthread killer([&] { server_.kill(); });
    EXPECT_GT(expect_equal_frames(*cluster, 4), 0U);
    killer.join();
    ASSERT_TRUE(has_nodes(*cluster, 0));
    server_.restart();
    ASSERT_TRUE(has_nodes(*cluster, 1)) << "both are connected again";
    const std::int64_t used = cluster->counters().used;
    EXPECT_TRUE(eventually([&] {
      expect_equal_frames(*cluster, 1);
      return cluster->counters().used > used || HasFailure();
    }));
  }
}

TEST_F(Cluster, AnotherServerOfTheirClusterTakesOver) {
  const Port routes[2];
  TempDir folders[2];
  const auto configuration = [&](int i) {
    return "cluster: {name: pair, listen: \"127.0.0.1:" + std::to_string(routes[i].number()) +
           "\", routes: [\"nats://127.0.0.1:" + std::to_string(routes[1 - i].number()) + "\"]}\n";
  };
  NatsServer first(folders[0].path(), configuration(0));
  const NatsServer second(folders[1].path(), configuration(1));
  const TestWorker worker(second.url());  // another, and yet it is heard
  ConnectionOptions both;
  both.servers = {first.url(), second.url()};
  const auto cluster = remote_coordinator(both, milliseconds(100));
  ASSERT_TRUE(has_nodes(*cluster, 1));
  first.kill();
  const std::int64_t used = cluster->counters().used;
  EXPECT_TRUE(eventually([&] {
    expect_equal_frames(*cluster, 1);
    return cluster->counters().used > used + 10 || HasFailure();
  }));
}

TEST_F(Cluster, ServersMayComeLater) {
  server_.kill();
  const auto cluster = coordinator(false, milliseconds(50));
  const TestWorker worker(server_.url());
  EXPECT_GT(expect_equal_frames(*cluster, 3), 0U);
  EXPECT_THAT(events(), HasSubstr("no NATS server can be reached"));
  server_.restart();
  EXPECT_TRUE(has_nodes(*cluster, 1));
}

// A worker behind a network of its own.
class FarWorker {
 public:
  explicit FarWorker(int server_port)
      : link_(port_.number(), server_port), worker_("nats://127.0.0.1:" + std::to_string(port_.number())) {}
  [[nodiscard]] testing::LinkSettings& link() { return link_.settings(); }

 private:
  Port port_;
  ThrottledLink link_;
  TestWorker worker_;
};

TEST_F(Cluster, SlowAndDelayedNetworksGiveTheSerialAnswer) {
  FarWorker slow(server_.port());
  slow.link().bytes_per_ms = 2000;
  FarWorker delayed(server_.port());
  delayed.link().delay_ms = 15;
  const auto cluster = coordinator(false, milliseconds(20'000), 32);
  ASSERT_TRUE(has_nodes(*cluster, 2));
  EXPECT_GT(expect_equal_frames(*cluster, 12), 1000U);
  EXPECT_TRUE(nearly_all_by_nodes(cluster->counters()));
  for (const ClusterNode& node : cluster->nodes()) EXPECT_GT(node.done, 0) << node.node;
}

TEST_F(Cluster, AWorkersNetworkThatStandsStillLosesNoFrame) {
  FarWorker worker(server_.port());
  const auto cluster = coordinator(false, milliseconds(100), 32);
  ASSERT_TRUE(has_nodes(*cluster, 1));
  for (int turn = 0; turn < 2; ++turn) {
    const std::int64_t used = cluster->counters().used;
    EXPECT_TRUE(eventually([&] {
      expect_equal_frames(*cluster, 1);
      return cluster->counters().used > used || HasFailure();
    }));
    worker.link().stalled = true;
    const std::int64_t taken_back = cluster->counters().taken_back;
    EXPECT_GT(expect_equal_frames(*cluster, 4), 0U);
    EXPECT_GT(cluster->counters().taken_back, taken_back);
    EXPECT_TRUE(has_nodes(*cluster, 0)) << "it says nothing any more";
    worker.link().stalled = false;
    ASSERT_TRUE(has_nodes(*cluster, 1)) << "it is heard again";
  }
}

TEST_F(Cluster, TheCoordinatorsOwnNetworkMayStandStill) {
  const TestWorker worker(server_.url());
  const Port port;
  ThrottledLink link(port.number(), server_.port());
  const auto cluster =
      remote_coordinator(connection_to("nats://127.0.0.1:" + std::to_string(port.number())), milliseconds(100), 32);
  ASSERT_TRUE(has_nodes(*cluster, 1));
  EXPECT_GT(expect_equal_frames(*cluster, 3), 0U);
  link.settings().stalled = true;
  EXPECT_GT(expect_equal_frames(*cluster, 10), 0U);
  EXPECT_TRUE(has_nodes(*cluster, 0));
  link.settings().stalled = false;
  ASSERT_TRUE(has_nodes(*cluster, 1));
  const std::int64_t used = cluster->counters().used;
  EXPECT_TRUE(eventually([&] {
    expect_equal_frames(*cluster, 1);
    return cluster->counters().used > used || HasFailure();
  }));
}

}  // namespace
}  // namespace cylpose::cluster
