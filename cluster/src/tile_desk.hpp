// Who is there, who has which tile, and what came of it: everything between frames and the network.
#pragma once

#include <cylpose/cluster/backend.hpp>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "cost_model.hpp"
#include "frame_work.hpp"
#include "message.hpp"
#include "nats.hpp"
#include "outbox.hpp"

namespace cylpose::cluster {

class TileDesk {
 public:
  /// Throws like Connection.
  explicit TileDesk(const ClusterOptions& options);

  /// Nodes that take tiles now, and what they cost.
  struct NodeOffer {
    std::string node;
    Offer offer;
    double claimed_pixels_per_ms;
    bool probed;  ///< measured, and not long ago
    int open;     ///< tiles that it has
  };
  [[nodiscard]] std::vector<NodeOffer> offers() const;

  /// Wakes `work` once, as soon as a node has room that it may not have had before.
  void wake_when_free(const std::shared_ptr<FrameWork>& work);

  /// Most rows of so wide an image that the server takes in one message, halo not counted; 0 when there is no server.
  [[nodiscard]] int most_rows(int width, PixelFormat format) const;

  /// Gives a tile to a node. The result goes to `work->pieces[piece]`, and `work->changed` is notified, also when the
  /// tile fails. Without `work` the tile is only measured. `origin` is what (0, 0) of the tile is in the frame.
  void send(const std::string& node, Tile tile, const Roi& origin, const std::shared_ptr<FrameWork>& work,
            std::size_t piece);

  [[nodiscard]] std::vector<ClusterNode> nodes() const;
  [[nodiscard]] ClusterCounters counters() const;
  void count_frame(bool shared, std::int64_t taken_back);

 private:
  struct Node {
    int slots = 0;
    double pixels_per_ms = 0;
    CostModel cost;
    Clock::time_point heard;
    Clock::time_point answered;  ///< last
    Clock::time_point tried;     ///< sent a tile, last
    int open = 0;                ///< tiles not answered
    std::int64_t done = 0;
    std::int64_t failed = 0;
  };
  struct OpenTile {
    std::string node;
    std::shared_ptr<FrameWork> work;
    std::size_t piece;
    Roi origin;
    Rows rows;  ///< of the tile's image
    std::size_t parts;
    Clock::time_point sent;
  };

  void on_hello(const NatsMessage& message);
  void on_result(const NatsMessage& message);
  void accept(std::uint64_t id, TileResult&& result);
  void fail(std::uint64_t id, bool node_is_gone);
  void keep_house();
  void forget_all();
  void wake_waiting();  ///< call with `mutex_` held
  void tell(const std::string& what) const;
  void tell_once(const std::string& about, const std::string& what);
  void refuse(const std::string& node, const std::string& reason);

  std::function<void(const std::string&)> on_event_;
  std::string session_ = random_word(12);
  Connection connection_;
  mutable std::mutex mutex_;
  std::map<std::string, Node> nodes_;
  std::map<std::uint64_t, OpenTile> open_;
  std::set<std::weak_ptr<FrameWork>, std::owner_less<>> waiting_;  ///< for room at a node
  std::uint64_t last_id_ = 0;
  ClusterCounters counters_;
  std::set<std::string> told_;
  bool was_connected_ = false;
  Listener hellos_;
  Listener results_;
  Outbox outbox_;  ///< ends first
};

}  // namespace cylpose::cluster
