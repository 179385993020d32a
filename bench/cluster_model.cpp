#include "cluster_model.hpp"

#include <algorithm>
#include <functional>
#include <queue>
#include <vector>

namespace cylpose::bench {
namespace {

constexpr int kHalo = 8;

struct Event {
  double ms;
  int node;  ///< whose answer is complete
  friend bool operator>(const Event& a, const Event& b) { return a.ms > b.ms; }
};

}  // namespace

double frame_ms(const ClusterWorld& world, int under_way) {
  constexpr int kFrames = 200;
  std::priority_queue<Event, std::vector<Event>, std::greater<>> answers;
  std::vector<double> node_free(static_cast<std::size_t>(world.nodes));
  std::vector<double> node_link_free(node_free.size());
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
      double& link_free = node_link_free[static_cast<std::size_t>(node - node_free.begin())];
      const double arrived = std::max(link_free, out_free + world.hop_ms) + bytes / world.node_link_mb_per_s * 1e-3;
      link_free = arrived;
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

}  // namespace cylpose::bench
