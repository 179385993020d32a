// The cluster backend: the tiles of a frame on other machines and, at the same time, on the local device.
#pragma once

#include <chrono>
#include <cstdint>
#include <cylpose/backend.hpp>
#include <cylpose/cluster/connection.hpp>
#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace cylpose::cluster {

struct ClusterOptions {
  ConnectionOptions connection;
  /// What nodes have not delivered by then, from a frame's start, is done locally, whatever was expected of them.
  /// Above 0.
  std::chrono::milliseconds deadline{50};
  /// The local device works on the frame from the start. Off, it only does what nodes do not: for measuring nodes, and
  /// where the machine has better things to do.
  bool share_local = true;
  /// Rows of a tile. 0: as many as nodes and the server's largest message let expect. Tiles that the server would not
  /// take are cut in any case.
  int tile_rows = 0;
  /// Told once what the user should know: a node of another version, a server lost and back. From any thread.
  std::function<void(const std::string& what)> on_event;

  [[nodiscard]] bool is_valid(std::string* why) const;
};

/// What became of tiles so far.
struct ClusterCounters {
  std::int64_t frames = 0;
  std::int64_t shared_frames = 0;  ///< with tiles elsewhere
  std::int64_t sent = 0;           ///< tiles sent, those for measuring included
  std::int64_t used = 0;           ///< results that were the first for their tile
  std::int64_t late = 0;           ///< results for tiles that were done by then
  std::int64_t refused = 0;        ///< results that were damaged, impossible or of an unknown tile
  std::int64_t taken_back = 0;     ///< tiles sent and then done locally
};

struct ClusterNode {
  std::string node;  ///< name.random
  int slots = 0;
  double pixels_per_ms = 0;  ///< as it says itself
  std::int64_t done = 0;     ///< results of it that were used
  std::int64_t failed = 0;   ///< tiles that it did not or not properly answer
};

class ClusterBackend : public Backend {
 public:
  /// The nodes that can be given tiles now.
  [[nodiscard]] virtual std::vector<ClusterNode> nodes() const = 0;
  [[nodiscard]] virtual ClusterCounters counters() const = 0;
};

/// The edge field is that of the serial backend, bit for bit, provided that `local` gives it; nodes that come, go, fail
/// or are late change nothing but the time. Masks (DetectOptions::with_mask) are always made locally. Throws
/// Error(kInput) for options, Error(kDevice) when a server refuses us; a server that is not there is waited for in the
/// background.
[[nodiscard]] std::unique_ptr<ClusterBackend> make_cluster_backend(std::unique_ptr<Backend> local,
                                                                   const ClusterOptions& options);

}  // namespace cylpose::cluster
