// nats-server and worker processes of the tests' own, on free ports, in folders of their own.
#pragma once

#include <chrono>
#include <cylpose/cluster/connection.hpp>
#include <filesystem>
#include <string>
#include <thread>
#include <vector>

namespace cylpose::testing {

/// A program started with arguments; killed at the latest with the object. Its output goes to a file.
class Process {
 public:
  Process() = default;
  Process(const std::vector<std::string>& words, std::filesystem::path output);
  ~Process();
  Process(Process&& other) noexcept;
  Process& operator=(Process&& other) noexcept;

  [[nodiscard]] int id() const { return id_; }
  [[nodiscard]] std::string output() const;
  void send(int signal) const;
  [[nodiscard]] bool has_ended() const;
  /// Exit code, or 128 + the signal that ended it.
  int wait();
  /// kill -9 and wait.
  void kill();

 private:
  std::filesystem::path output_;
  int id_ = -1;  ///< -1: none, or waited for
};

/// For what comes at once unless the machine is busy.
inline constexpr std::chrono::milliseconds kPatience{60'000};

/// Waits for something to become true, and looks often; false when patience is at its end.
template <typename Condition>
bool eventually(Condition condition) {
  const auto end = std::chrono::steady_clock::now() + kPatience;
  while (!condition()) {
    if (std::chrono::steady_clock::now() > end) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  return true;
}

/// A port that no other test takes, though nobody listens on it: below those that the system gives to clients, or one
/// of them could get it, or even reach itself there, while a server is down.
class Port {
 public:
  Port();
  ~Port();
  Port(const Port&) = delete;
  Port& operator=(const Port&) = delete;
  [[nodiscard]] int number() const { return number_; }

 private:
  static constexpr int kFirst = 20'000;
  static constexpr int kLast = 32'000;
  int number_ = 0;
  int claim_ = -1;
};

class NatsServer {
 public:
  /// Ready when this returns. `configuration`: the text of a configuration file, without a port.
  explicit NatsServer(const std::filesystem::path& folder, const std::string& configuration = {});

  [[nodiscard]] std::string url(const std::string& scheme = "nats") const;
  [[nodiscard]] int port() const { return port_.number(); }
  void kill() { process_.kill(); }
  /// On the same port.
  void restart();
  [[nodiscard]] std::string log() const { return process_.output(); }
  [[nodiscard]] int id() const { return process_.id(); }

 private:
  void start();

  std::filesystem::path folder_;
  std::string configuration_;
  Port port_;
  Process process_;
};

inline cluster::ConnectionOptions connection_to(const std::string& url) {
  cluster::ConnectionOptions options;
  options.servers = {url};
  return options;
}

}  // namespace cylpose::testing
