// What a frame costs on machines that are not there: a discrete-event model of the cluster backend (docs/scaling.md).
//
// One coordinator sends tiles one after the other over its own link; the server passes them on; nodes take turns and
// work on one tile at a time; answers come back over the coordinator's other direction; then edges are located.
#pragma once

namespace cylpose::bench {

struct ClusterWorld {
  int nodes = 1;
  double link_mb_per_s = 125;       ///< of the coordinator, each direction
  double node_link_mb_per_s = 125;  ///< of each node
  double hop_ms = 0.1;              ///< from sending to arriving, beyond the bytes' own time
  double tile_ms = 0.05;            ///< of the coordinator for a tile, beyond its bytes: message, system calls
  double ms_per_mpixel = 0.45;      ///< of a node
  double locate_ms = 0.25;          ///< of the coordinator, per frame
  int width = 1280;
  int height = 720;
  int tile_rows = 128;
  int answer_bytes = 12'000;
};

/// Milliseconds per frame when `under_way` frames overlap: the time at which the last of many is done, by their number.
[[nodiscard]] double frame_ms(const ClusterWorld& world, int under_way);

}  // namespace cylpose::bench
