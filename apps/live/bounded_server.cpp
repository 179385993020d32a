#include "bounded_server.hpp"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <httplib.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cylpose/error.hpp>
#include <future>
#include <mutex>
#include <set>
#include <system_error>

namespace cylpose::apps {
namespace {

using Clock = std::chrono::steady_clock;

/// Runs at once, on the thread that accepts: the server hands over or refuses by itself.
class AtOnce : public httplib::TaskQueue {
 public:
  void enqueue(std::function<void()> task) override { task(); }
  void shutdown() override {}
};

bool wait_for(int socket, short events, Clock::time_point end) {
  for (;;) {
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(end - Clock::now());
    pollfd entry{socket, events, 0};
    const int ready = ::poll(&entry, 1, static_cast<int>(std::max<std::int64_t>(left.count(), 0)));
    if (ready < 0 && errno == EINTR) continue;
    return ready > 0 && (entry.revents & events) != 0;
  }
}

/// A socket that gives a request no more than its bytes and time.
class BoundedStream : public httplib::Stream {
 public:
  BoundedStream(int socket, const ServerLimits& limits)
      : socket_(socket), limits_(limits), end_of_request_(Clock::now() + limits.request_time) {}

  [[nodiscard]] bool is_readable() const override { return wait_for(socket_, POLLIN, end_of_request_); }

  /// False, too, once the reader has closed the connection.
  [[nodiscard]] bool is_writable() const override {
    char byte = 0;
    if (::recv(socket_, &byte, 1, MSG_PEEK | MSG_DONTWAIT) == 0) return false;
    return wait_for(socket_, POLLOUT, Clock::now() + limits_.write_patience);
  }

  ssize_t read(char* to, std::size_t size) override {
    if (at_ == filled_) {
      if (taken_ >= limits_.request_bytes || !is_readable()) return -1;
      const ssize_t count =
          ::recv(socket_, buffer_.data(), std::min(buffer_.size(), limits_.request_bytes - taken_), 0);
      if (count <= 0) return count;
      at_ = 0;
      filled_ = static_cast<std::size_t>(count);
      taken_ += filled_;
    }
    const std::size_t given = std::min(size, filled_ - at_);
    std::copy_n(buffer_.begin() + static_cast<std::ptrdiff_t>(at_), given, to);
    at_ += given;
    return static_cast<ssize_t>(given);
  }

  ssize_t write(const char* from, std::size_t size) override {
    if (!wait_for(socket_, POLLOUT, Clock::now() + limits_.write_patience)) return -1;
    return ::send(socket_, from, size, MSG_NOSIGNAL | MSG_DONTWAIT);
  }

  void get_remote_ip_and_port(std::string& /*ip*/, int& /*port*/) const override {}
  void get_local_ip_and_port(std::string& /*ip*/, int& /*port*/) const override {}
  [[nodiscard]] socket_t socket() const override { return socket_; }

 private:
  int socket_;
  ServerLimits limits_;
  Clock::time_point end_of_request_;
  std::array<char, 1024> buffer_{};
  std::size_t at_ = 0;
  std::size_t filled_ = 0;
  std::size_t taken_ = 0;
};

/// Lets the reader have what was written, even if not all it sent was read: closing at once would take it back.
void finish_gently(int socket) {
  ::shutdown(socket, SHUT_WR);
  constexpr std::chrono::milliseconds kPatience(200);
  constexpr std::size_t kMost = 65536;
  std::array<char, 4096> unread{};
  const Clock::time_point end = Clock::now() + kPatience;
  for (std::size_t taken = 0; taken < kMost && wait_for(socket, POLLIN, end);) {
    const ssize_t count = ::recv(socket, unread.data(), unread.size(), MSG_DONTWAIT);
    if (count <= 0) break;
    taken += static_cast<std::size_t>(count);
  }
}

bool is_loopback(const std::string& host) {
  if (host == "localhost" || host == "::1" || host == "[::1]") return true;
  in_addr four{};
  constexpr std::uint32_t kNetwork = 127;
  return ::inet_pton(AF_INET, host.c_str(), &four) == 1 && ntohl(four.s_addr) >> 24U == kNetwork;
}

/// The host of a Host header, without its port.
std::string host_in(const std::string& header) {
  const std::size_t bracket = header.rfind(']');
  const std::size_t colon = header.rfind(':');
  const bool has_port = colon != std::string::npos && (bracket == std::string::npos || colon > bracket);
  return has_port ? header.substr(0, colon) : header;
}

}  // namespace

class BoundedServer::Impl : private httplib::Server {
 public:
  Impl(const std::string& address, int port, Answer answer, const HttpHeaders& headers, const ServerLimits& limits)
      : address_(address), answer_(std::move(answer)), limits_(limits), workers_(limits.connections) {
    new_task_queue = [] { return new AtOnce; };
    set_default_headers({headers.begin(), headers.end()});
    // httplib's own option lets another process of the user share the port.
    set_socket_options([](socket_t socket) {
      const int yes = 1;
      ::setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
    });
    set_pre_routing_handler([this](const httplib::Request& request, httplib::Response& response) {
      route(request, response);
      return HandlerResponse::Handled;
    });
    errno = 0;
    port_ = port == 0 ? bind_to_any_port(address) : (bind_to_port(address, port) ? port : -1);
    if (port_ > 0) return;
    const std::string why = errno == 0 ? "no address of this machine" : std::generic_category().message(errno);
    workers_.shutdown();
    throw Error(ErrorKind::kOutput, fmt::format("{} port {}: cannot be served on: {}; choose another port, or 0 for "
                                                "one that is free",
                                                address, port, why));
  }

  ~Impl() override {
    stop();
    workers_.shutdown();
  }

  void start() {
    listener_ = std::async(std::launch::async, [this] { return listen_after_bind(); });
    // httplib's stop() does nothing before it listens.
    while (!is_running() && listener_.wait_for(std::chrono::milliseconds(1)) == std::future_status::timeout) {
    }
  }

  void stop() {
    Server::stop();
    if (listener_.valid()) listener_.wait();
    const std::scoped_lock lock(mutex_);
    for (const socket_t socket : connections_) ::shutdown(socket, SHUT_RDWR);
  }

  [[nodiscard]] int port() const { return port_; }
  [[nodiscard]] const std::string& address() const { return address_; }

 private:
  // On the thread that accepts.
  bool process_and_close_socket(socket_t socket) override {
    {
      const std::scoped_lock lock(mutex_);
      if (connections_.size() < limits_.connections) {
        connections_.insert(socket);
        workers_.enqueue([this, socket] { serve(socket); });
        return true;
      }
    }
    constexpr std::string_view kBusy =
        "HTTP/1.1 503 Service Unavailable\r\nRetry-After: 1\r\nContent-Length: 0\r\nConnection: close\r\n\r\n";
    ::send(socket, kBusy.data(), kBusy.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
    ::shutdown(socket, SHUT_RDWR);
    ::close(socket);
    return false;
  }

  void serve(socket_t socket) {
    // Who looks gives way to who works: on Linux that is a matter of the thread.
    constexpr int kNice = 10;
    ::setpriority(PRIO_PROCESS, static_cast<id_t>(::gettid()), kNice);
    BoundedStream stream(socket, limits_);
    bool closed = false;
    try {
      process_request(stream, true, closed, nullptr);
    } catch (const std::exception&) {
      // A request that broke the parser, or no memory: the connection ends, the server does not.
    }
    finish_gently(socket);
    const std::scoped_lock lock(mutex_);
    connections_.erase(socket);
    ::close(socket);
  }

  void route(const httplib::Request& request, httplib::Response& response) const {
    constexpr int kForbidden = 403, kNotAllowed = 405;
    if (request.method != "GET" && request.method != "HEAD") {
      response.status = kNotAllowed;
      response.set_header("Allow", "GET, HEAD");
      return;
    }
    if (is_loopback(address_) && !is_loopback(host_in(request.get_header_value("Host")))) {
      response.status = kForbidden;
      response.set_content("ask for localhost\n", "text/plain");
      return;
    }
    HttpAnswer answer = answer_(request.path);
    response.status = answer.status;
    for (const auto& [name, value] : answer.headers) response.set_header(name, value);
    if (!answer.stream) {
      if (!answer.type.empty()) response.set_content(answer.body, answer.type);
      return;
    }
    response.set_chunked_content_provider(
        answer.type, [stream = std::move(answer.stream)](std::size_t /*offset*/, httplib::DataSink& sink) {
          return stream([&sink](std::string_view bytes) { return sink.write(bytes.data(), bytes.size()); }) &&
                 sink.is_writable();
        });
  }

  std::string address_;
  Answer answer_;
  ServerLimits limits_;
  int port_ = 0;
  std::mutex mutex_;
  std::set<socket_t> connections_;
  httplib::ThreadPool workers_;
  std::future<bool> listener_;
};

BoundedServer::BoundedServer(const std::string& address, int port, Answer answer, const HttpHeaders& headers,
                             const ServerLimits& limits)
    : impl_(std::make_unique<Impl>(address, port, std::move(answer), headers, limits)) {}

BoundedServer::~BoundedServer() = default;

void BoundedServer::start() {
  impl_->start();
}

void BoundedServer::stop() {
  impl_->stop();
}

int BoundedServer::port() const {
  return impl_->port();
}

std::string BoundedServer::url() const {
  const std::string& address = impl_->address();
  const bool six = address.find(':') != std::string::npos;
  return fmt::format("http://{}{}{}:{}/", six ? "[" : "", address, six ? "]" : "", impl_->port());
}

}  // namespace cylpose::apps
