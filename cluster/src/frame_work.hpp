// The pieces of one frame, filled by whoever has one done first.
#pragma once

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <cylpose/edge_field.hpp>
#include <mutex>
#include <vector>

#include "strips.hpp"

namespace cylpose::cluster {

using Clock = std::chrono::steady_clock;

struct Piece {
  Rows rows;              ///< of the search region
  int copies = 0;         ///< with nodes at the moment
  int tries = 0;          ///< times that it was sent to a node
  Clock::time_point due;  ///< when a node's answer should be there, if copies > 0
  bool done = false;
  std::vector<PartEdges> parts;  ///< in frame coordinates, once done
};

class FrameWork {
 public:
  std::mutex mutex;
  std::condition_variable changed;
  std::vector<Piece> pieces;  ///< from top to bottom
  bool woken = false;         ///< something has happened: a piece, or room at a node

  void wake() {
    {
      const std::scoped_lock lock(mutex);
      woken = true;
    }
    changed.notify_all();
  }

  /// False when somebody was quicker. Call with `mutex` held.
  static bool deliver(Piece& piece, std::vector<PartEdges>&& parts) {
    if (piece.done) return false;
    piece.parts = std::move(parts);
    piece.done = true;
    return true;
  }

  /// Call with `mutex` held.
  [[nodiscard]] bool complete() const {
    return std::all_of(pieces.begin(), pieces.end(), [](const Piece& piece) { return piece.done; });
  }
};

}  // namespace cylpose::cluster
