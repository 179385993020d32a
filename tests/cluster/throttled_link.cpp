#include "throttled_link.hpp"

#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <condition_variable>
#include <deque>
#include <list>
#include <mutex>
#include <stdexcept>
#include <utility>
#include <vector>

namespace cylpose::testing {
namespace {

using Clock = std::chrono::steady_clock;

Clock::duration as_duration(double ms) {
  return std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double, std::milli>(ms));
}

class Socket {
 public:
  explicit Socket(int fd) : fd_(fd) {
    const int on = 1;
    ::setsockopt(fd_, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
    // What a link has not taken must hold up the sender and not fill the memory.
    const int bytes = 1 << 16;
    ::setsockopt(fd_, SOL_SOCKET, SO_RCVBUF, &bytes, sizeof bytes);
    ::setsockopt(fd_, SOL_SOCKET, SO_SNDBUF, &bytes, sizeof bytes);
  }
  ~Socket() { ::close(fd_); }
  Socket(const Socket&) = delete;
  Socket& operator=(const Socket&) = delete;
  [[nodiscard]] int fd() const { return fd_; }
  void end() const { ::shutdown(fd_, SHUT_RDWR); }

 private:
  int fd_;
};

bool send_all(int fd, const std::vector<char>& bytes) {
  for (std::size_t sent = 0; sent < bytes.size();) {
    const ssize_t some = ::send(fd, bytes.data() + sent, bytes.size() - sent, MSG_NOSIGNAL);
    if (some <= 0) return false;
    sent += static_cast<std::size_t>(some);
  }
  return true;
}

// One direction of a connection: what is read now is written when its delay is over and the rate allows.
class Direction {
 public:
  Direction(const Socket& from, const Socket& to, const LinkSettings& settings)
      : from_(from), to_(to), settings_(settings), reader_([this] { read(); }), writer_([this] { write(); }) {}

  [[nodiscard]] bool over() const { return over_; }

 private:
  struct Chunk {
    std::vector<char> bytes;
    Clock::time_point read;
  };

  void read() {
    constexpr std::size_t kChunk = 1 << 14;
    while (!over_) {
      Chunk chunk{std::vector<char>(kChunk), {}};
      const ssize_t some = ::recv(from_.fd(), chunk.bytes.data(), chunk.bytes.size(), 0);
      if (some <= 0) break;
      chunk.bytes.resize(static_cast<std::size_t>(some));
      chunk.read = Clock::now();
      std::unique_lock lock(mutex_);
      // As much is on its way as the link holds.
      const double room = static_cast<double>(4 * kChunk) + settings_.delay_ms * settings_.bytes_per_ms;
      changed_.wait(lock, [&] { return over_ || static_cast<double>(waiting_) < room; });
      waiting_ += chunk.bytes.size();
      chunks_.push_back(std::move(chunk));
      changed_.notify_all();
    }
    end();
  }

  void write() {
    auto free_at = Clock::now();
    while (true) {
      std::unique_lock lock(mutex_);
      changed_.wait(lock, [&] { return over_ || !chunks_.empty(); });
      if (over_) break;
      const Chunk chunk = std::move(chunks_.front());
      chunks_.pop_front();
      lock.unlock();
      // The line is busy with each chunk for as long as its bytes take, also where this thread came late.
      const double ms = static_cast<double>(chunk.bytes.size()) / settings_.bytes_per_ms;
      free_at = std::max(free_at, chunk.read) + as_duration(ms);
      std::this_thread::sleep_until(free_at + as_duration(settings_.delay_ms));
      constexpr std::chrono::milliseconds kLook{1};
      while (settings_.stalled && !over_) std::this_thread::sleep_for(kLook);
      if (!send_all(to_.fd(), chunk.bytes)) break;
      lock.lock();
      waiting_ -= chunk.bytes.size();
      changed_.notify_all();
    }
    end();
  }

  void end() {
    {
      const std::scoped_lock lock(mutex_);
      over_ = true;
    }
    changed_.notify_all();
    from_.end();
    to_.end();
  }

  const Socket& from_;
  const Socket& to_;
  const LinkSettings& settings_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<Chunk> chunks_;
  std::size_t waiting_ = 0;
  std::atomic<bool> over_ = false;
  std::jthread reader_;
  std::jthread writer_;
};

class Pair {
 public:
  Pair(int near, int far, const LinkSettings& settings)
      : near_(near), far_(far), out_(near_, far_, settings), back_(far_, near_, settings) {}
  ~Pair() {
    near_.end();
    far_.end();
  }
  Pair(const Pair&) = delete;
  Pair& operator=(const Pair&) = delete;
  [[nodiscard]] bool over() const { return out_.over() || back_.over(); }

 private:
  Socket near_;
  Socket far_;
  Direction out_;
  Direction back_;
};

sockaddr_in loopback(int port) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<std::uint16_t>(port));
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  return address;
}

}  // namespace

ThrottledLink::ThrottledLink(int from, int to) : to_(to), listener_(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
  const int on = 1;
  ::setsockopt(listener_, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
  const sockaddr_in address = loopback(from);
  if (::bind(listener_, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0 ||
      ::listen(listener_, SOMAXCONN) != 0) {
    ::close(listener_);
    throw std::runtime_error("no link: port " + std::to_string(from) + " is taken");
  }
  thread_ = std::jthread([this](const std::stop_token& stop) { accept_all(stop); });
}

ThrottledLink::~ThrottledLink() {
  thread_.request_stop();
  thread_.join();
  ::close(listener_);
}

void ThrottledLink::accept_all(const std::stop_token& stop) {
  std::list<Pair> pairs;
  while (!stop.stop_requested()) {
    pairs.remove_if([](const Pair& pair) { return pair.over(); });
    constexpr int kLookMs = 20;
    pollfd ready{listener_, POLLIN, 0};
    if (::poll(&ready, 1, kLookMs) <= 0) continue;
    const int near = ::accept4(listener_, nullptr, nullptr, SOCK_CLOEXEC);
    const int far = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    const sockaddr_in address = loopback(to_);
    if (near >= 0 && ::connect(far, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0) {
      pairs.emplace_back(near, far, settings_);
      continue;
    }
    ::close(near);
    ::close(far);
  }
}

}  // namespace cylpose::testing
