// Who is there: the answers of all workers, by the services convention of NATS.
#pragma once

#include <chrono>
#include <cstdint>
#include <cylpose/cluster/connection.hpp>
#include <string>
#include <vector>

namespace cylpose::cluster {

struct NodeReport {
  std::string name;
  std::string id;       ///< the random end of its name in subjects
  std::string version;  ///< of cylpose
  std::string device;
  std::string started;  ///< RFC 3339, UTC
  std::string kernels;
  std::uint32_t protocol = 0;
  std::int64_t done = 0;  ///< tiles
  std::int64_t failed = 0;
  double pixels_per_ms = 0;
  std::string last_error;
  bool usable = false;  ///< by this cylpose: the same protocol and kernels
};

/// Asks, and gathers the answers of `patience`. Throws Error(kInput) for options, Error(kDevice) when there is no
/// server or it refuses us.
[[nodiscard]] std::vector<NodeReport> list_nodes(const ConnectionOptions& connection,
                                                 std::chrono::milliseconds patience = std::chrono::milliseconds(500));

}  // namespace cylpose::cluster
