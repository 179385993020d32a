// From edge pixels to ordered chains of edge points: hysteresis and edge extraction (thesis algorithm 5.1).
#pragma once

#include <Eigen/Core>
#include <cylpose/camera.hpp>
#include <cylpose/edge_field.hpp>
#include <span>
#include <vector>

namespace cylpose {

/// One measured place on the border of the part, in pixels of the ideal camera: the camera without its distortion, same
/// focal length and principal point (straight lines are straight there).
struct EdgePoint {
  Eigen::Vector2d position_px;
  Eigen::Vector2d inward;        ///< unit normal of the border, pointing into the part
  EdgeCue cue = EdgeCue::kNone;  ///< that told where it is
};

/// An ordered run of neighbouring edge points, as indices.
using Chain = std::vector<int>;

/// The edge pixels that are strong or connected to a strong one through weak ones (8 neighbours); order kept.
[[nodiscard]] std::vector<EdgePixel> with_hysteresis(std::span<const EdgePixel> edges);

/// The located edge of each pixel, undistorted.
[[nodiscard]] std::vector<EdgePoint> edge_points(const CameraModel& camera, std::span<const EdgePixel> edges);

/// Every n-th of the points, n the smallest that leaves at most `at_most`: enough for a first look.
[[nodiscard]] std::vector<EdgePoint> thinned(std::span<const EdgePoint> points, std::size_t at_most);

/// Follows neighbouring edge pixels from the top row down (thesis algorithm 5.1), straight on where there is a choice,
/// in both directions from where it starts. Every pixel is in one chain at most; chains shorter than `min_length`
/// pixels are left out. `edges` in row-major order, as backends deliver them.
[[nodiscard]] std::vector<Chain> extract_chains(std::span<const EdgePixel> edges, int min_length);

/// Cuts chains where they bend (Ramer 1972, Douglas and Peucker 1973; thesis algorithm 5.2): a piece is divided at its
/// point farthest from the line through its ends while that distance is at least `max_distance_px`. Pieces of less than
/// `min_length` points are left out.
[[nodiscard]] std::vector<Chain> split_where_bent(std::span<const Chain> chains, std::span<const EdgePoint> points,
                                                  double max_distance_px, int min_length);

}  // namespace cylpose
