// A node that does what a test wants instead of what it should.
#pragma once

#include <atomic>
#include <cylpose/cluster/backend.hpp>
#include <functional>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "message.hpp"
#include "nats.hpp"
#include "servers.hpp"

namespace cylpose::testing {

class FakeNode {
 public:
  using Bytes = std::vector<std::uint8_t>;
  struct Asked {
    std::string reply;
    Bytes message;
  };
  /// Gets every message to the node, and what to publish through; from the node's thread.
  using Answer = std::function<void(const cluster::Connection& connection, const Asked& asked)>;

  FakeNode(const std::string& url, Answer answer, std::function<Bytes(const std::string& node)> hello = {})
      : node_("fake." + cluster::random_word(4)), connection_(connection_to(url), node_) {
    tiles_ = connection_.subscribe("cylpose.tile." + node_);
    who_ = std::make_unique<cluster::Listener>(connection_, "cylpose.who",
                                               [this, hello](const cluster::NatsMessage&) { say(hello); });
    thread_ = std::jthread([this, answer = std::move(answer), hello](const std::stop_token& stop) {
      for (int turn = 0; !stop.stop_requested(); ++turn) {
        if (turn % 16 == 0) say(hello);
        const cluster::NatsMessage message = cluster::next_message(tiles_, std::chrono::milliseconds(20));
        if (message == nullptr) continue;
        const auto data = cluster::data_of(message);
        const char* reply = natsMsg_GetReply(message.get());
        answer(connection_, {reply != nullptr ? reply : "", {data.begin(), data.end()}});
      }
    });
  }

  [[nodiscard]] const std::string& name() const { return node_; }
  [[nodiscard]] const cluster::Connection& connection() const { return connection_; }

  /// What an honest node would answer.
  static cluster::TileResult honest(const Asked& asked) {
    static const std::unique_ptr<Backend> serial = make_backend("serial");
    const cluster::Message message = cluster::decode(asked.message);
    const auto& tile = std::get<cluster::Tile>(message.body);
    DetectOptions options;
    options.edge_low = tile.edge_low;
    options.edge_high = tile.edge_high;
    options.rows = tile.rows;
    options.locate = false;
    return {tile.id, 1, {}, serial->detect(tile.image, tile.image.bounds(), tile.parts, options).parts};
  }

  static void publish(const cluster::Connection& connection, const std::string& subject,
                      const cluster::TileResult& result) {
    const cluster::Buffer buffer = encode(result);
    connection.publish(subject, {buffer.data(), buffer.size()});
  }

 private:
  void say(const std::function<Bytes(const std::string&)>& hello) const {
    if (hello) {
      const Bytes bytes = hello(node_);
      connection_.publish("cylpose.node." + node_, bytes);
      return;
    }
    const cluster::Buffer bytes = encode(cluster::Hello{node_, 8, 1e6});
    connection_.publish("cylpose.node." + node_, {bytes.data(), bytes.size()});
  }

  std::string node_;
  cluster::Connection connection_;
  cluster::NatsSubscription tiles_;
  std::unique_ptr<cluster::Listener> who_;
  std::jthread thread_;
};

}  // namespace cylpose::testing
