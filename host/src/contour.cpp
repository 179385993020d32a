#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cylpose/contour.hpp>
#include <numbers>
#include <numeric>
#include <optional>

namespace cylpose {
namespace {

// Calls `link` for every two edge pixels that touch, found by walking pairs of rows side by side.
template <typename Link>
void for_each_link(std::span<const EdgePixel> edges, const Link& link) {
  std::size_t above = 0;
  for (std::size_t i = 0; i < edges.size(); ++i) {
    const EdgePixel& pixel = edges[i];
    if (i > 0 && edges[i - 1].y == pixel.y && edges[i - 1].x == pixel.x - 1) link(i - 1, i);
    while (edges[above].y < pixel.y - 1 || (edges[above].y == pixel.y - 1 && edges[above].x < pixel.x - 1)) ++above;
    for (std::size_t k = above; edges[k].y == pixel.y - 1 && edges[k].x <= pixel.x + 1; ++k) link(k, i);
  }
}

// The up to eight neighbours of every edge pixel.
class Neighbours {
 public:
  explicit Neighbours(std::span<const EdgePixel> edges) : of_(edges.size()) {
    for_each_link(edges, [this](std::size_t a, std::size_t b) {
      of_[a].index[static_cast<std::size_t>(of_[a].count++)] = static_cast<int>(b);
      of_[b].index[static_cast<std::size_t>(of_[b].count++)] = static_cast<int>(a);
    });
  }

  [[nodiscard]] std::span<const int> operator[](int i) const {
    const List& list = of_[static_cast<std::size_t>(i)];
    return {list.index.data(), static_cast<std::size_t>(list.count)};
  }

 private:
  struct List {
    std::array<int, 8> index;
    int count = 0;
  };

  std::vector<List> of_;
};

// Which pixels hang together: a forest in which every pixel leads to the first one of its kind (union-find).
class ConnectedPixels {
 public:
  explicit ConnectedPixels(std::size_t count) : toward_root_(count) {
    std::iota(toward_root_.begin(), toward_root_.end(), 0U);
  }

  [[nodiscard]] std::uint32_t root(std::size_t i) {
    auto at = static_cast<std::uint32_t>(i);
    while (toward_root_[at] != at) at = toward_root_[at] = toward_root_[toward_root_[at]];
    return at;
  }

  void join(std::size_t a, std::size_t b) {
    const auto [first, second] = std::minmax({root(a), root(b)});
    toward_root_[second] = first;
  }

 private:
  std::vector<std::uint32_t> toward_root_;
};

struct Step {
  int x;
  int y;
};

Step step_between(const EdgePixel& from, const EdgePixel& to) {
  return {to.x - from.x, to.y - from.y};
}

// The unvisited neighbour that best continues the way so far; a direct neighbour before a diagonal one where both do.
std::optional<int> next_neighbour(int at, Step heading, std::span<const EdgePixel> edges, const Neighbours& neighbours,
                                  const std::vector<std::uint8_t>& visited) {
  std::optional<int> best;
  double best_score = 0;
  for (const int candidate : neighbours[at]) {
    if (visited[static_cast<std::size_t>(candidate)] != 0) continue;
    const Step step = step_between(edges[static_cast<std::size_t>(at)], edges[static_cast<std::size_t>(candidate)]);
    const double length = step.x != 0 && step.y != 0 ? std::numbers::sqrt2 : 1.0;
    const double score = (step.x * heading.x + step.y * heading.y) / length - 0.1 * length;
    if (!best || score > best_score) {
      best = candidate;
      best_score = score;
    }
  }
  return best;
}

void follow(Chain& chain, std::span<const EdgePixel> edges, const Neighbours& neighbours,
            std::vector<std::uint8_t>& visited) {
  constexpr std::size_t kHeadingSpan =
      4;  // the heading is that of the last few pixels: one step knows only 8 directions
  while (true) {
    const int at = chain.back();
    const int before = chain[chain.size() > kHeadingSpan ? chain.size() - 1 - kHeadingSpan : 0];
    const Step heading = step_between(edges[static_cast<std::size_t>(before)], edges[static_cast<std::size_t>(at)]);
    const auto next = next_neighbour(at, heading, edges, neighbours, visited);
    if (!next) return;
    visited[static_cast<std::size_t>(*next)] = 1;
    chain.push_back(*next);
  }
}

// Distance from the line through two points; from the first one where they coincide.
class Chord {
 public:
  Chord(const Eigen::Vector2d& from, const Eigen::Vector2d& to) : from_(from) {
    const Eigen::Vector2d along = to - from;
    const double length = along.norm();
    is_point_ = !(length > 0);
    if (!is_point_) normal_ = Eigen::Vector2d(-along.y(), along.x()) / length;
  }

  [[nodiscard]] double distance(const Eigen::Vector2d& point) const {
    return is_point_ ? (point - from_).norm() : std::abs(normal_.dot(point - from_));
  }

 private:
  Eigen::Vector2d from_;
  Eigen::Vector2d normal_ = Eigen::Vector2d::Zero();
  bool is_point_;
};

}  // namespace

std::vector<EdgePixel> with_hysteresis(std::span<const EdgePixel> edges) {
  ConnectedPixels connected(edges.size());
  for_each_link(edges, [&](std::size_t a, std::size_t b) { connected.join(a, b); });
  std::vector<std::uint8_t> kept(edges.size(), 0);
  for (std::size_t i = 0; i < edges.size(); ++i) {
    if (edges[i].strength == EdgeStrength::kStrong) kept[connected.root(i)] = 1;
  }
  std::vector<EdgePixel> result;
  result.reserve(edges.size());
  for (std::size_t i = 0; i < edges.size(); ++i) {
    if (kept[connected.root(i)] != 0) result.push_back(edges[i]);
  }
  return result;
}

std::vector<EdgePoint> edge_points(const CameraModel& camera, std::span<const EdgePixel> edges) {
  std::vector<EdgePoint> points;
  points.reserve(edges.size());
  for (const EdgePixel& edge : edges) {
    const Eigen::Vector2d inward = Eigen::Vector2d(edge.gx, edge.gy).normalized();
    points.push_back({Eigen::Vector2d(edge.x, edge.y) + inward * (edge.offset_256 / 256.0), inward, edge.cue});
  }
  if (camera.distortion_model != DistortionModel::kNone) {
    std::vector<Eigen::Vector2d> located;
    located.reserve(points.size());
    for (const EdgePoint& point : points) located.push_back(point.position_px);
    const std::vector<Eigen::Vector2d> rays = undistorted(camera, located);
    for (std::size_t i = 0; i < points.size(); ++i) {
      points[i].position_px = ideal_pixel(camera, {rays[i].x(), rays[i].y(), 1});
    }
  }
  return points;
}

std::vector<EdgePoint> thinned(std::span<const EdgePoint> points, std::size_t at_most) {
  const std::size_t step = std::max<std::size_t>(1, (points.size() + at_most - 1) / at_most);
  std::vector<EdgePoint> kept;
  kept.reserve(points.size() / step + 1);
  for (std::size_t i = 0; i < points.size(); i += step) kept.push_back(points[i]);
  return kept;
}

std::vector<Chain> extract_chains(std::span<const EdgePixel> edges, int min_length) {
  const Neighbours neighbours(edges);
  std::vector<std::uint8_t> visited(edges.size(), 0);
  std::vector<Chain> chains;
  for (std::size_t start = 0; start < edges.size(); ++start) {
    if (visited[start] != 0) continue;
    visited[start] = 1;
    Chain chain{static_cast<int>(start)};
    follow(chain, edges, neighbours, visited);
    std::reverse(chain.begin(), chain.end());
    follow(chain, edges, neighbours, visited);
    if (static_cast<int>(chain.size()) >= min_length) chains.push_back(std::move(chain));
  }
  return chains;
}

std::vector<Chain> split_where_bent(std::span<const Chain> chains, std::span<const EdgePoint> points,
                                    double max_distance_px, int min_length) {
  struct Piece {
    std::size_t first;
    std::size_t last;
  };
  std::vector<Chain> segments;
  std::vector<Piece> to_check;
  for (const Chain& chain : chains) {
    const auto position = [&](std::size_t i) -> const Eigen::Vector2d& {
      return points[static_cast<std::size_t>(chain[i])].position_px;
    };
    to_check.push_back({0, chain.size() - 1});
    while (!to_check.empty()) {
      const Piece piece = to_check.back();
      to_check.pop_back();
      if (static_cast<int>(piece.last - piece.first) + 1 < min_length) continue;
      std::size_t farthest = piece.first;
      double distance = 0;
      const Chord chord(position(piece.first), position(piece.last));
      for (std::size_t i = piece.first + 1; i < piece.last; ++i) {
        const double d = chord.distance(position(i));
        if (d > distance) {
          distance = d;
          farthest = i;
        }
      }
      if (distance < max_distance_px) {
        segments.emplace_back(chain.begin() + static_cast<std::ptrdiff_t>(piece.first),
                              chain.begin() + static_cast<std::ptrdiff_t>(piece.last) + 1);
      } else {
        to_check.push_back({farthest, piece.last});
        to_check.push_back({piece.first, farthest});
      }
    }
  }
  return segments;
}

}  // namespace cylpose
