#include "outbox.hpp"

#include <utility>

namespace cylpose::cluster {

Outbox::Outbox(const Connection& connection, std::function<void(std::uint64_t)> failed, std::function<void()> idle)
    : connection_(connection),
      failed_(std::move(failed)),
      idle_(std::move(idle)),
      thread_([this](const std::stop_token& stop) { run(stop); }) {}

Outbox::~Outbox() {
  thread_.request_stop();
  thread_.join();
}

void Outbox::put(std::uint64_t id, std::string subject, std::string reply, Buffer data) {
  {
    const std::scoped_lock lock(mutex_);
    letters_.push_back({id, std::move(subject), std::move(reply), std::move(data)});
  }
  changed_.notify_one();
}

bool Outbox::stuck() const {
  constexpr std::chrono::milliseconds kUsual{20};  // a large tile on a slow link takes longer: then there is no room
  const std::scoped_lock lock(mutex_);
  return sending_since_ != Clock::time_point::max() && Clock::now() - sending_since_ > kUsual;
}

void Outbox::run(const std::stop_token& stop) {
  constexpr std::chrono::milliseconds kIdle{100};
  auto last_idle = Clock::now();
  while (!stop.stop_requested()) {
    Letter letter;
    {
      std::unique_lock lock(mutex_);
      sending_since_ = Clock::time_point::max();
      changed_.wait_for(lock, stop, kIdle, [this] { return !letters_.empty(); });
      if (!letters_.empty()) {
        letter = std::move(letters_.front());
        letters_.pop_front();
        sending_since_ = Clock::now();
      }
    }
    if (!letter.subject.empty()) {
      const bool sent = connection_.connected() &&
                        connection_.publish(letter.subject, {letter.data.data(), letter.data.size()}, letter.reply);
      if (!sent) failed_(letter.id);
    }
    if (const auto now = Clock::now(); now - last_idle > kIdle) {
      last_idle = now;
      idle_();
    }
  }
}

}  // namespace cylpose::cluster
