// What a frame costs on machines that are not there: a discrete-event model of the cluster backend with constants as
// measured, for 1 to 1000 nodes (docs/scaling.md).
//
//   cylpose_cluster_model       a table: frame time and frames a second by nodes, link rate and tile size
//
// One coordinator sends tiles one after the other over its own link; the server passes them on; nodes take turns and
// work on one tile at a time; answers come back over the coordinator's other direction; then edges are located.
#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <queue>
#include <vector>

namespace {

struct World {
  int nodes = 1;
  double link_mb_per_s = 125;   ///< of each machine, each direction
  double hop_ms = 0.1;          ///< from sending to arriving, beyond the bytes' own time
  double tile_ms = 0.05;        ///< of the coordinator for a tile, beyond its bytes: message, system calls
  double ms_per_mpixel = 0.45;  ///< of a node
  double locate_ms = 0.25;      ///< of the coordinator, per frame
  int width = 1280;
  int height = 720;
  int tile_rows = 128;
  int answer_bytes = 12'000;
};

constexpr int kHalo = 8;

struct Event {
  double ms;
  int node;  ///< whose answer is complete
  friend bool operator>(const Event& a, const Event& b) { return a.ms > b.ms; }
};

// Milliseconds per frame when `under_way` frames overlap: the time at which the last of many is done, by their number.
double frame_ms(const World& world, int under_way) {
  constexpr int kFrames = 200;
  std::priority_queue<Event, std::vector<Event>, std::greater<>> answers;
  std::vector<double> node_free(static_cast<std::size_t>(world.nodes));
  double out_free = 0;
  double in_free = 0;
  double core_free = 0;
  std::vector<double> done;
  for (int frame = 0; frame < kFrames; ++frame) {
    const double start = frame < under_way ? 0 : done[static_cast<std::size_t>(frame - under_way)];
    for (int row = 0; row < world.height; row += world.tile_rows) {
      const int rows = std::min(world.tile_rows, world.height - row);
      const double bytes = 3.0 * world.width * (rows + kHalo);
      out_free = std::max(out_free, start) + world.tile_ms + bytes / world.link_mb_per_s * 1e-3;
      const auto node = std::ranges::min_element(node_free);
      const double arrived = out_free + world.hop_ms + bytes / world.link_mb_per_s * 1e-3;
      *node = std::max(*node, arrived) + world.ms_per_mpixel * world.width * (rows + kHalo) * 1e-6;
      answers.push({*node + world.hop_ms, static_cast<int>(node - node_free.begin())});
    }
    double last = start;
    for (; !answers.empty(); answers.pop()) {
      in_free = std::max(in_free, answers.top().ms) + world.answer_bytes / world.link_mb_per_s * 1e-3;
      last = std::max(last, in_free);
    }
    core_free = std::max(core_free, last) + world.locate_ms;
    done.push_back(core_free);
  }
  return done.back() / kFrames;
}

}  // namespace

int main() {
  fmt::print("{:>8} {:>12} {:>6} | {:>10} {:>10} | {:>10} {:>10}\n", "nodes", "link MB/s", "rows", "fast ms",
             "frames/s", "slow ms", "frames/s");
  for (const double link : {12.5, 125.0, 1250.0}) {
    for (const int nodes : {1, 2, 4, 8, 32, 100, 1000}) {
      for (const int rows : {32, 128}) {
        World world;
        world.nodes = nodes;
        world.link_mb_per_s = link;
        world.tile_rows = rows;
        World slow = world;
        slow.ms_per_mpixel = 50;  // a small board, or a frame with much more work
        fmt::print("{:>8} {:>12} {:>6} | {:>10.2f} {:>10.1f} | {:>10.2f} {:>10.1f}\n", nodes, link, rows,
                   frame_ms(world, 1), 1e3 / frame_ms(world, nodes + 1), frame_ms(slow, 1),
                   1e3 / frame_ms(slow, nodes + 1));
      }
    }
  }
}
