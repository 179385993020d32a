#include "tile_desk.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cylpose/error.hpp>
#include <utility>

namespace cylpose::cluster {
namespace {

constexpr std::chrono::seconds kSilence{3};     // of a node that is gone; it says something twice a second
constexpr std::chrono::seconds kTileExpiry{2};  // for a result to be worth anything, if only to know how slow a node is

double ms_between(Clock::time_point from, Clock::time_point to) {
  return std::chrono::duration<double, std::milli>(to - from).count();
}

std::optional<std::uint64_t> id_in(std::string_view subject) {
  const std::string_view word = subject.substr(subject.rfind('.') + 1);
  std::uint64_t id = 0;
  const auto [end, failure] = std::from_chars(word.data(), word.data() + word.size(), id);
  if (failure != std::errc() || end != word.data() + word.size()) return std::nullopt;
  return id;
}

}  // namespace

TileDesk::TileDesk(const ClusterOptions& options)
    : on_event_(options.on_event),
      connection_(options.connection, "cylpose coordinator"),
      hellos_(connection_, "cylpose.node.*.*", [this](const NatsMessage& message) { on_hello(message); }),
      results_(connection_, "cylpose.result." + session_ + ".*",
               [this](const NatsMessage& message) { on_result(message); }),
      outbox_(
          connection_, [this](std::uint64_t id) { fail(id, false); }, [this] { keep_house(); }) {
  if (!connection_.connected()) tell("no NATS server can be reached; working locally until one can");
}

std::vector<TileDesk::NodeOffer> TileDesk::offers() const {
  std::vector<NodeOffer> offers;
  if (outbox_.stuck()) return offers;
  constexpr std::chrono::seconds kProbeAgain{10};
  const auto now = Clock::now();
  const std::scoped_lock lock(mutex_);
  for (const auto& [name, node] : nodes_) {
    const bool probed = node.cost.known() && now - node.tried < kProbeAgain;
    if (node.open < node.slots) {
      offers.push_back({name, {node.cost, node.slots - node.open}, node.pixels_per_ms, probed, node.open});
    }
  }
  return offers;
}

void TileDesk::wake_when_free(const std::shared_ptr<FrameWork>& work) {
  const std::scoped_lock lock(mutex_);
  waiting_.insert(work);
}

void TileDesk::wake_waiting() {
  for (const std::weak_ptr<FrameWork>& waiting : waiting_) {
    if (const std::shared_ptr<FrameWork> work = waiting.lock()) work->wake();
  }
  waiting_.clear();
}

int TileDesk::most_rows(int width, PixelFormat format) const {
  const std::size_t payload = connection_.most_payload();
  if (payload <= kTileOverhead) return 0;
  const auto row_bytes = static_cast<std::size_t>(width) * static_cast<std::size_t>(bytes_per_pixel(format));
  return std::max(0, static_cast<int>((payload - kTileOverhead) / row_bytes) - 2 * kStripHalo);
}

void TileDesk::send(const std::string& node, Tile tile, const Roi& origin, const std::shared_ptr<FrameWork>& work,
                    std::size_t piece) {
  {
    const std::scoped_lock lock(mutex_);
    const auto found = nodes_.find(node);
    if (found == nodes_.end()) return;
    tile.id = ++last_id_;
    ++found->second.open;
    ++counters_.sent;
    const auto now = Clock::now();
    found->second.tried = now;
    const double pixels = static_cast<double>(origin.width) * (tile.rows.end - tile.rows.first);
    const double ms = found->second.cost.ms(pixels);
    open_[tile.id] = {node, work, piece, origin, tile.rows, tile.parts.size(), now};
    if (work != nullptr) {
      constexpr double kPatience = 1.5;
      constexpr double kLeastMs = 1;
      constexpr double kNewcomersMs = 10;  // what its link costs nobody knows yet
      const std::scoped_lock frame_lock(work->mutex);
      Piece& target = work->pieces[piece];
      ++target.copies;
      ++target.tries;
      const double claimed_ms = pixels / std::max(1.0, found->second.pixels_per_ms);
      const double wait_ms = kPatience * found->second.open * (found->second.cost.known() ? ms : claimed_ms) +
                             (found->second.cost.known() ? kLeastMs : kNewcomersMs);
      target.due =
          now + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double, std::milli>(wait_ms));
    }
  }
  outbox_.put(tile.id, "cylpose.tile." + node, fmt::format("cylpose.result.{}.{}", session_, tile.id), encode(tile));
}

void TileDesk::on_hello(const NatsMessage& message) {
  try {
    const Message read = decode(data_of(message));
    const std::string subject = natsMsg_GetSubject(message.get());
    const std::string name = subject.substr(std::string_view("cylpose.node.").size());
    if (const std::string conflict = version_conflict(read, "node " + name); !conflict.empty()) {
      refuse(name, conflict);
      return;
    }
    const auto* hello = std::get_if<Hello>(&read.body);
    // The server's permissions say who may publish on a subject, so the subject is what to believe.
    if (hello == nullptr || hello->node != name) return;
    const std::scoped_lock lock(mutex_);
    if (hello->slots == 0) {
      nodes_.erase(name);
      return;
    }
    Node& node = nodes_[name];
    node.slots = hello->slots;
    node.pixels_per_ms = hello->pixels_per_ms;
    node.heard = Clock::now();
    wake_waiting();
  } catch (const Error&) {
    const std::scoped_lock lock(mutex_);
    ++counters_.refused;
  }
}

void TileDesk::on_result(const NatsMessage& message) {
  const std::optional<std::uint64_t> id = id_in(natsMsg_GetSubject(message.get()));
  if (!id) return;
  if (natsMsg_IsNoResponders(message.get())) {
    fail(*id, true);
    return;
  }
  try {
    Message read = decode(data_of(message));
    if (const std::string conflict = version_conflict(read, "a node"); !conflict.empty()) {
      tell_once("result", conflict);
      fail(*id, true);
      return;
    }
    auto* result = std::get_if<TileResult>(&read.body);
    if (result == nullptr || result->id != *id) throw Error(ErrorKind::kInput, "a result for another tile");
    accept(*id, std::move(*result));
  } catch (const Error& error) {
    {
      const std::scoped_lock lock(mutex_);
      ++counters_.refused;
    }
    tell_once("refused", fmt::format("a result was refused: {}", error.what()));
    fail(*id, false);
  }
}

void TileDesk::accept(std::uint64_t id, TileResult&& result) {
  const auto now = Clock::now();
  std::unique_lock lock(mutex_);
  const auto found = open_.find(id);
  if (found == open_.end()) {
    ++counters_.refused;
    return;
  }
  if (!result.error.empty()) {
    const std::string node = found->second.node;
    lock.unlock();
    tell_once(node + " failed", fmt::format("node {}: {}", node, result.error));
    fail(id, false);
    return;
  }
  require_fits(result, found->second.origin.width, found->second.rows, found->second.parts);
  const OpenTile tile = std::move(found->second);
  open_.erase(found);
  const double pixels = static_cast<double>(tile.origin.width) * (tile.rows.end - tile.rows.first);
  const auto node = nodes_.find(tile.node);
  if (node != nodes_.end()) {
    // Where tiles queue up at a node, each has only cost the time since the one before.
    node->second.cost.add(pixels, ms_between(std::max(tile.sent, node->second.answered), now));
    node->second.answered = now;
    node->second.open = std::max(0, node->second.open - 1);
  }
  wake_waiting();
  if (tile.work == nullptr) return;
  for (PartEdges& part : result.parts) shift(part, tile.origin.x, tile.origin.y);
  bool first = false;
  {
    const std::scoped_lock frame_lock(tile.work->mutex);
    Piece& piece = tile.work->pieces[tile.piece];
    --piece.copies;
    first = FrameWork::deliver(piece, std::move(result.parts));
  }
  ++(first ? counters_.used : counters_.late);
  if (first && node != nodes_.end()) ++node->second.done;
  tile.work->wake();
}

void TileDesk::fail(std::uint64_t id, bool node_is_gone) {
  const std::scoped_lock lock(mutex_);
  const auto found = open_.find(id);
  if (found == open_.end()) return;
  const OpenTile tile = std::move(found->second);
  open_.erase(found);
  if (const auto node = nodes_.find(tile.node); node != nodes_.end()) {
    ++node->second.failed;
    node->second.open = std::max(0, node->second.open - 1);
    if (node_is_gone) nodes_.erase(node);
  }
  wake_waiting();
  if (tile.work == nullptr) return;
  {
    const std::scoped_lock frame_lock(tile.work->mutex);
    --tile.work->pieces[tile.piece].copies;
  }
  tile.work->wake();
}

void TileDesk::keep_house() {
  const bool connected = connection_.connected();
  const auto now = Clock::now();
  if (connected != was_connected_) {
    was_connected_ = connected;
    if (connected) {
      connection_.publish("cylpose.who", std::string());
      tell_once("back", "connected to the NATS server");
    } else {
      forget_all();
      tell(connection_.closed() ? "the NATS server refuses us: " + connection_.last_error()
                                : "the NATS server is gone; working locally until it is back");
      const std::scoped_lock lock(mutex_);
      told_.erase("back");
    }
  }
  std::vector<std::pair<std::uint64_t, double>> expired;
  {
    const std::scoped_lock lock(mutex_);
    std::erase_if(nodes_, [&](const auto& entry) { return now - entry.second.heard > kSilence; });
    for (const auto& [id, tile] : open_) {
      if (now - tile.sent <= kTileExpiry) continue;
      expired.emplace_back(id, ms_between(tile.sent, now));
      if (const auto node = nodes_.find(tile.node); node != nodes_.end()) {
        node->second.cost.add(static_cast<double>(tile.origin.width) * (tile.rows.end - tile.rows.first),
                              expired.back().second);
      }
    }
  }
  for (const auto& [id, ms] : expired) fail(id, false);
}

void TileDesk::forget_all() {
  std::vector<std::uint64_t> ids;
  {
    const std::scoped_lock lock(mutex_);
    nodes_.clear();
    for (const auto& [id, tile] : open_) ids.push_back(id);
  }
  for (const std::uint64_t id : ids) fail(id, false);
}

void TileDesk::refuse(const std::string& node, const std::string& reason) {
  tell_once(node, "refused: " + reason);
  const Buffer refusal = encode(Refusal{reason});
  connection_.publish("cylpose.tile." + node, {refusal.data(), refusal.size()});
}

void TileDesk::tell(const std::string& what) const {
  if (on_event_) on_event_(what);
}

void TileDesk::tell_once(const std::string& about, const std::string& what) {
  {
    const std::scoped_lock lock(mutex_);
    constexpr std::size_t kMost = 1000;  // strangers must not fill the memory
    if (told_.size() >= kMost || !told_.insert(about).second) return;
  }
  tell(what);
}

std::vector<ClusterNode> TileDesk::nodes() const {
  const std::scoped_lock lock(mutex_);
  std::vector<ClusterNode> all;
  for (const auto& [name, node] : nodes_) all.push_back({name, node.slots, node.pixels_per_ms, node.done, node.failed});
  return all;
}

ClusterCounters TileDesk::counters() const {
  const std::scoped_lock lock(mutex_);
  return counters_;
}

void TileDesk::count_frame(bool shared, std::int64_t taken_back) {
  const std::scoped_lock lock(mutex_);
  ++counters_.frames;
  counters_.shared_frames += shared ? 1 : 0;
  counters_.taken_back += taken_back;
}

}  // namespace cylpose::cluster
