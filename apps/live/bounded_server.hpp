// An HTTP server that only gives, and that no client can make large or hold for long: limits on connections, on the
// bytes and seconds of a request, and on waiting for slow readers. Underneath is cpp-httplib.
#pragma once

#include <chrono>
#include <cstddef>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace cylpose::apps {

struct ServerLimits {
  std::size_t connections = 16;                     ///< at once; further ones are told 503
  std::size_t request_bytes = 8192;                 ///< request line and headers
  std::chrono::milliseconds request_time{5'000};    ///< until the request is there
  std::chrono::milliseconds write_patience{5'000};  ///< for a reader that takes nothing
};

using HttpHeaders = std::vector<std::pair<std::string, std::string>>;

/// False once the reader is gone.
using WriteChunk = std::function<bool(std::string_view bytes)>;

struct HttpAnswer {
  int status = 200;
  std::string type;
  std::string body;
  HttpHeaders headers = {};
  /// In place of a body: called again and again until it returns false or the reader is gone, and then destroyed.
  std::function<bool(const WriteChunk& write)> stream = {};
};

/// One request per connection; GET and HEAD, 405 for all else. On a loopback address only requests for a loopback name
/// are answered, so that no web page reaches the server by a name of its own that leads here (DNS rebinding).
class BoundedServer {
 public:
  using Answer = std::function<HttpAnswer(const std::string& path)>;

  /// Binds; connections wait until start(). Port 0: any that is free. `answer` is called on the connections' threads,
  /// which have less priority than others of the process; `headers` go with every answer. Throws Error(kOutput) for an
  /// address that is not this machine's, or a port that is taken or not allowed.
  BoundedServer(const std::string& address, int port, Answer answer, const HttpHeaders& headers,
                const ServerLimits& limits = {});
  ~BoundedServer();
  BoundedServer(const BoundedServer&) = delete;
  BoundedServer& operator=(const BoundedServer&) = delete;

  void start();
  /// Takes no more connections and closes those there are.
  void stop();

  [[nodiscard]] int port() const;
  [[nodiscard]] std::string url() const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace cylpose::apps
