// The services convention of NATS (ADR-32): who answers to $SRV.PING, INFO and STATS shows up in NATS's own tools.
#pragma once

#include <chrono>
#include <cstdint>
#include <mutex>
#include <string>
#include <string_view>

#include "nats.hpp"

namespace cylpose::cluster {

/// Name of the service that all workers are.
inline constexpr const char* kService = "cylpose";

struct ServiceIdentity {
  std::string node;      ///< name of the worker
  std::string id;        ///< unique
  std::string endpoint;  ///< subject of its tiles
  std::string device;
};

class Service {
 public:
  /// Answers from now on.
  Service(const Connection& connection, ServiceIdentity identity);
  Service(const Service&) = delete;
  Service& operator=(const Service&) = delete;

  void count(double busy_ms, double pixels);
  void count_failure(const std::string& why);
  /// Of the last tiles.
  [[nodiscard]] double pixels_per_ms() const;

 private:
  /// PING, INFO or STATS; empty for what is asked of others.
  [[nodiscard]] std::string verb_for_us(std::string_view subject) const;
  [[nodiscard]] std::string reply_to(const std::string& verb) const;

  ServiceIdentity identity_;
  std::chrono::system_clock::time_point started_ = std::chrono::system_clock::now();
  mutable std::mutex mutex_;
  std::int64_t requests_ = 0;
  std::int64_t failures_ = 0;
  double busy_ms_ = 0;
  double pixels_per_ms_ = 0;
  std::string last_error_;
  Listener listener_;  ///< ends first
};

}  // namespace cylpose::cluster
