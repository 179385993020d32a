// Messages on their way to the network, which may block: nobody who has a frame to do waits for that.
#pragma once

#include <condition_variable>
#include <cstddef>
#include <deque>
#include <functional>
#include <mutex>
#include <string>
#include <thread>

#include "frame_work.hpp"
#include "message.hpp"
#include "nats.hpp"

namespace cylpose::cluster {

class Outbox {
 public:
  /// `failed` gets the id of what could not be sent; `idle` is called some ten times a second. Both from the outbox's
  /// thread.
  Outbox(const Connection& connection, std::function<void(std::uint64_t id)> failed, std::function<void()> idle);
  ~Outbox();
  Outbox(const Outbox&) = delete;
  Outbox& operator=(const Outbox&) = delete;

  void put(std::uint64_t id, std::string subject, std::string reply, Buffer data);

  /// The network has taken nothing for a while, though there is something.
  [[nodiscard]] bool stuck() const;

 private:
  struct Letter {
    std::uint64_t id;
    std::string subject;
    std::string reply;
    Buffer data;
  };
  void run(const std::stop_token& stop);

  const Connection& connection_;
  std::function<void(std::uint64_t)> failed_;
  std::function<void()> idle_;
  mutable std::mutex mutex_;
  std::condition_variable_any changed_;
  std::deque<Letter> letters_;
  Clock::time_point sending_since_ = Clock::time_point::max();
  std::jthread thread_;
};

}  // namespace cylpose::cluster
