// Algorithms 5.1 and 5.2: from the edge image to ordered edges, and from edges to pieces without bends.
#include <array>
#include <cmath>
#include <cylpose/thesis.hpp>

namespace cylpose {
namespace {

// Direct neighbours before diagonal ones, so that following an edge takes the corner pixels along instead of leaving
// them behind as crumbs.
constexpr std::array<std::array<int, 2>, 8> kNeighbours = {
    {{1, 0}, {0, 1}, {-1, 0}, {0, -1}, {1, 1}, {-1, 1}, {-1, -1}, {1, -1}}};

// Distance of a point from the line through a and b; from a where the two are one.
class ChordDistance {
 public:
  ChordDistance(const Eigen::Vector2d& a, const Eigen::Vector2d& b) : a_(a), along_(b - a), length_(along_.norm()) {}

  double operator()(const Eigen::Vector2d& point) const {
    const Eigen::Vector2d offset = point - a_;
    return length_ == 0 ? offset.norm() : std::abs(along_.x() * offset.y() - along_.y() * offset.x()) / length_;
  }

 private:
  Eigen::Vector2d a_;
  Eigen::Vector2d along_;
  double length_;
};

}  // namespace

std::vector<std::vector<Eigen::Vector2d>> thesis_edges(const Mask& edge_image, int min_size) {
  const Roi& roi = edge_image.roi;
  std::vector<std::uint8_t> left = edge_image.pixels;  // not yet in an edge
  const auto at = [&](int x, int y) -> std::uint8_t& {
    return left[static_cast<std::size_t>(y) * static_cast<std::size_t>(roi.width) + static_cast<std::size_t>(x)];
  };
  std::vector<std::vector<Eigen::Vector2d>> edges;
  std::vector<Eigen::Vector2d> edge;
  for (int row = 0; row < roi.height; ++row) {
    for (int column = 0; column < roi.width; ++column) {
      if (at(column, row) == 0) continue;
      edge.clear();
      int x = column;
      int y = row;
      for (bool more = true; more;) {
        at(x, y) = 0;  // the first pixel, too: the printed algorithm forgets it
        edge.emplace_back(roi.x + x, roi.y + y);
        more = false;
        for (const auto& [dx, dy] : kNeighbours) {
          const int nx = x + dx;
          const int ny = y + dy;
          if (nx < 0 || ny < 0 || nx >= roi.width || ny >= roi.height || at(nx, ny) == 0) continue;
          x = nx;
          y = ny;
          more = true;
          break;
        }
      }
      if (edge.size() > static_cast<std::size_t>(min_size)) edges.push_back(edge);
    }
  }
  return edges;
}

std::vector<EdgePiece> thesis_pieces(std::span<const Eigen::Vector2d> edge, int min_size, double max_distance_px) {
  std::vector<EdgePiece> pieces;
  std::vector<EdgePiece> open;  // a stack instead of recursion: edges are as long as the image allows
  const auto keep_if_long = [&](const EdgePiece& piece) {
    if (piece.end - piece.begin >= static_cast<std::size_t>(min_size)) open.push_back(piece);
  };
  keep_if_long({0, edge.size()});
  while (!open.empty()) {
    const EdgePiece piece = open.back();
    open.pop_back();
    const ChordDistance distance(edge[piece.begin], edge[piece.end - 1]);
    std::size_t farthest = piece.begin;
    double largest = 0;
    for (std::size_t i = piece.begin; i < piece.end; ++i) {
      const double d = distance(edge[i]);
      if (d > largest) {
        largest = d;
        farthest = i;
      }
    }
    if (largest < max_distance_px) {
      pieces.push_back(piece);
    } else {
      keep_if_long({farthest, piece.end});
      keep_if_long({piece.begin, farthest + 1});  // on top, so that pieces come out in order
    }
  }
  return pieces;
}

}  // namespace cylpose
