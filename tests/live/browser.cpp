#include "browser.hpp"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdlib>
#include <system_error>

namespace cylpose::testing {

Connection::Connection(int port, const std::string& address) : socket_(::socket(AF_INET, SOCK_STREAM, 0)) {
  sockaddr_in to{};
  to.sin_family = AF_INET;
  to.sin_port = htons(static_cast<std::uint16_t>(port));
  ::inet_pton(AF_INET, address.c_str(), &to.sin_addr);
  if (::connect(socket_, reinterpret_cast<const sockaddr*>(&to), sizeof to) != 0) {
    const int why = errno;
    ::close(socket_);
    throw std::system_error(why, std::generic_category(), "connect");
  }
}

Connection::~Connection() {
  ::close(socket_);
}

bool Connection::send(const std::string& bytes) const {
  for (std::size_t at = 0; at < bytes.size();) {
    const ssize_t count = ::send(socket_, bytes.data() + at, bytes.size() - at, MSG_NOSIGNAL);
    if (count <= 0) return false;
    at += static_cast<std::size_t>(count);
  }
  return true;
}

std::string Connection::read_until(const std::string& end) const {
  std::string text;
  std::array<char, 65536> buffer{};
  while (end.empty() || text.find(end) == std::string::npos) {
    const ssize_t count = ::recv(socket_, buffer.data(), buffer.size(), 0);
    if (count <= 0) break;
    text.append(buffer.data(), static_cast<std::size_t>(count));
  }
  return text;
}

std::string Connection::read_all() const {
  return read_until("");
}

Answered answered(int port, const std::string& request) {
  const Connection connection(port);
  connection.send(request);
  const std::string text = connection.read_all();
  const std::size_t end = text.find("\r\n\r\n");
  constexpr std::size_t kPlaceOfStatus = 9;
  if (end == std::string::npos) return {};
  return {std::atoi(text.c_str() + kPlaceOfStatus), text.substr(0, end), text.substr(end + 4)};
}

Answered get(int port, const std::string& path) {
  return answered(port, "GET " + path + " HTTP/1.1\r\nHost: localhost\r\n\r\n");
}

}  // namespace cylpose::testing
