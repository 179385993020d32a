// nats-server and worker processes of the tests' own, on free ports, in folders of their own.
#pragma once

#include <filesystem>
#include <string>
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
  /// Exit code, or 128 + the signal that ended it.
  int wait();
  /// kill -9 and wait.
  void kill();

 private:
  std::filesystem::path output_;
  int id_ = -1;  ///< -1: none, or waited for
};

/// Waits for something to become true, and looks often; false after ten seconds.
template <typename Condition>
bool eventually(Condition condition);

class NatsServer {
 public:
  /// Ready when this returns. `configuration`: the text of a configuration file, without a port.
  explicit NatsServer(const std::filesystem::path& folder, const std::string& configuration = {});

  [[nodiscard]] std::string url(const std::string& scheme = "nats") const;
  [[nodiscard]] int port() const { return port_; }
  void kill() { process_.kill(); }
  /// On the same port.
  void restart();
  [[nodiscard]] std::string log() const { return process_.output(); }
  [[nodiscard]] int id() const { return process_.id(); }

 private:
  void start();

  std::filesystem::path folder_;
  std::string configuration_;
  int port_ = -1;
  Process process_;
};

}  // namespace cylpose::testing

#include <chrono>
#include <thread>

template <typename Condition>
bool cylpose::testing::eventually(Condition condition) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(10);
  while (!condition()) {
    if (std::chrono::steady_clock::now() > end) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  return true;
}
