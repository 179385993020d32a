#include <fmt/format.h>

#include <atomic>
#include <cylpose/cluster/worker.hpp>
#include <cylpose/error.hpp>
#include <mutex>
#include <set>
#include <thread>

#include "frame_work.hpp"
#include "message.hpp"
#include "nats.hpp"
#include "service.hpp"

namespace cylpose::cluster {
namespace {

class Node {
 public:
  Node(Backend& backend, const WorkerOptions& options)
      : backend_(backend),
        options_(options),
        id_(random_word(4)),
        node_(options.name + "." + id_),
        connection_(options.connection, "cylpose worker " + node_),
        tiles_(connection_.subscribe("cylpose.tile." + node_)),
        service_(connection_, {options.name, id_, "cylpose.tile." + node_, options.device}) {
    // Tiles that nobody waits for any more are not worth keeping.
    constexpr int kMostBytes = 1 << 28;
    check(natsSubscription_SetPendingLimits(tiles_.get(), options.slots * 8, kMostBytes),
          "natsSubscription_SetPendingLimits");
    warm_up();
  }

  void run(const std::function<bool()>& stop) {
    const Listener who(connection_, "cylpose.who", [this](const NatsMessage&) { say_hello(); });
    const std::jthread pulse([this](const std::stop_token& end) { beat(end); });
    constexpr std::chrono::milliseconds kPatience{50};
    while (!stop()) {
      if (const NatsMessage message = next_message(tiles_, kPatience)) {
        answer(message);
      } else if (connection_.closed()) {
        throw Error(ErrorKind::kDevice, "the NATS server refuses us: " + connection_.last_error());
      }
    }
    leaving_ = true;
    say_hello();
    natsSubscription_Drain(tiles_.get());
    while (const NatsMessage message = next_message(tiles_, kPatience)) answer(message);
    constexpr std::int64_t kFlushMs = 1000;
    natsConnection_FlushTimeout(connection_.get(), kFlushMs);
  }

 private:
  // Kernels are built before anybody waits for them; and a first rate.
  void warm_up() {
    constexpr int kWidth = 640;
    constexpr int kHeight = 160;
    const std::vector<std::uint8_t> pixels(std::size_t{3} * kWidth * kHeight, 90);
    const ImageView image{pixels.data(), kWidth, kHeight, std::ptrdiff_t{3} * kWidth, PixelFormat::kBgr8};
    const std::vector<PartModel> parts{{"part", 1, 1, 200, 260, 0.3, 0.2}};
    DetectOptions options;
    options.locate = false;
    for (int i = 0; i < 3; ++i) {
      const auto start = Clock::now();
      static_cast<void>(backend_.detect(image, image.bounds(), parts, options));
      const double ms = std::chrono::duration<double, std::milli>(Clock::now() - start).count();
      pixels_per_ms_ = kWidth * kHeight / std::max(ms, 1e-3);
    }
  }

  void beat(const std::stop_token& end) {
    constexpr std::chrono::milliseconds kStep{100};
    constexpr int kStepsToHello = 5;
    bool was_connected = false;
    for (int step = 0; !end.stop_requested(); ++step, std::this_thread::sleep_for(kStep)) {
      const bool connected = connection_.connected();
      if (connected != was_connected) {
        tell(connected ? fmt::format("node {} is connected and asks for tiles", node_)
                       : "the NATS server is gone; trying again until it is back");
      }
      if ((connected && !was_connected) || step % kStepsToHello == 0) say_hello();
      was_connected = connected;
    }
  }

  // From three threads; the last word must be the one that we are leaving.
  void say_hello() {
    const double measured = service_.pixels_per_ms();
    const std::scoped_lock lock(hello_);
    const Buffer hello = encode(Hello{node_, leaving_ ? 0 : options_.slots, measured > 0 ? measured : pixels_per_ms_});
    if (connection_.connected()) connection_.publish("cylpose.node." + node_, {hello.data(), hello.size()});
  }

  void answer(const NatsMessage& message) {
    TileResult result;
    try {
      const Message read = decode(data_of(message));
      const std::string conflict = version_conflict(read, "a coordinator");
      if (const auto* refusal = std::get_if<Refusal>(&read.body)) {
        tell_once("refused: " + refusal->reason);
        return;
      }
      if (!conflict.empty()) throw Error(ErrorKind::kInput, conflict);
      const auto* tile = std::get_if<Tile>(&read.body);
      if (tile == nullptr) return;
      result = done(*tile);
      service_.count(result.busy_ms, static_cast<double>(tile->image.width) * (tile->rows.end - tile->rows.first));
    } catch (const Error& error) {
      result.error = error.what();
      service_.count_failure(error.what());
      tell_once(fmt::format("a tile failed: {}", error.what()));
    }
    const char* reply = natsMsg_GetReply(message.get());
    if (reply == nullptr) return;
    const std::string_view subject = reply;
    if (!result.error.empty()) result.id = id_after_dot(subject);
    Buffer answer = encode(result);
    if (answer.size() > connection_.most_payload()) {
      TileResult failed;
      failed.id = result.id;
      failed.error =
          fmt::format("the result of {} bytes is more than the server takes; raise its max_payload", answer.size());
      answer = encode(failed);
    }
    connection_.publish(reply, {answer.data(), answer.size()});
  }

  TileResult done(const Tile& tile) {
    DetectOptions options;
    options.edge_low = tile.edge_low;
    options.edge_high = tile.edge_high;
    options.rows = tile.rows;
    options.locate = false;
    TileResult result;
    result.id = tile.id;
    const auto start = Clock::now();
    result.parts = backend_.detect(tile.image, tile.image.bounds(), tile.parts, options).parts;
    result.busy_ms = std::chrono::duration<double, std::milli>(Clock::now() - start).count();
    return result;
  }

  // So that a tile that cannot be read is answered nevertheless.
  static std::uint64_t id_after_dot(std::string_view subject) {
    return std::strtoull(std::string(subject.substr(subject.rfind('.') + 1)).c_str(), nullptr, 10);
  }

  void tell(const std::string& what) const {
    if (options_.on_event) options_.on_event(what);
  }

  void tell_once(const std::string& what) {
    constexpr std::size_t kMost = 1000;
    if (told_.size() < kMost && told_.insert(what).second) tell(what);
  }

  Backend& backend_;
  const WorkerOptions& options_;
  std::string id_;
  std::string node_;
  double pixels_per_ms_ = 0;
  std::mutex hello_;
  std::atomic<bool> leaving_ = false;
  std::set<std::string> told_;
  Connection connection_;
  NatsSubscription tiles_;
  Service service_;  ///< who sees us there may send tiles
};

}  // namespace

bool WorkerOptions::is_valid(std::string* why) const {
  const auto refuse = [why](std::string reason) {
    if (why != nullptr) *why = std::move(reason);
    return false;
  };
  constexpr std::string_view kPlain = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789-_";
  constexpr std::size_t kLongest = 64;
  constexpr int kMostSlots = 64;
  if (!connection.is_valid(why)) return false;
  if (name.empty() || name.size() > kLongest || name.find_first_not_of(kPlain) != std::string::npos) {
    return refuse("the name is '" + name + "'; use 1 to 64 letters, digits, - and _");
  }
  if (slots < 1 || slots > kMostSlots) return refuse("slots are " + std::to_string(slots) + "; must be 1 to 64");
  return true;
}

void run_worker(Backend& backend, const WorkerOptions& options, const std::function<bool()>& stop) {
  if (std::string why; !options.is_valid(&why)) throw Error(ErrorKind::kInput, "options of the worker: " + why);
  Node(backend, options).run(stop);
}

}  // namespace cylpose::cluster
