// What talks to the live page's server over real sockets: politely, and otherwise.
#pragma once

#include <string>

namespace cylpose::testing {

/// A connection to a port of an IPv4 address of this machine; throws std::system_error where nobody listens.
class Connection {
 public:
  explicit Connection(int port, const std::string& address = "127.0.0.1");
  ~Connection();
  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;

  /// False when the other side has closed.
  bool send(const std::string& bytes) const;
  /// All that comes until `end` is in it, or the other side closes.
  [[nodiscard]] std::string read_until(const std::string& end) const;
  [[nodiscard]] std::string read_all() const;

 private:
  int socket_;
};

struct Answered {
  int status = 0;  ///< 0: closed without an answer
  std::string head;
  std::string body;
};

/// One request, all of it by hand.
[[nodiscard]] Answered answered(int port, const std::string& request);

/// GET as browsers do.
[[nodiscard]] Answered get(int port, const std::string& path);

}  // namespace cylpose::testing
