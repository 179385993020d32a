// The outline that a pose predicts, to be compared with measured edge points. Pixels of the ideal camera.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cylpose/camera.hpp>
#include <cylpose/contour.hpp>
#include <cylpose/cylinder.hpp>
#include <cylpose/image_line.hpp>
#include <cylpose/part.hpp>
#include <optional>
#include <vector>

namespace cylpose {

/// The four pieces of an outline: two sides, and the arcs of the two bases. They index arrays of kOutlinePieces.
inline constexpr int kOutlinePieces = 4;
enum OutlinePiece : std::size_t { kSide0 = 0, kSide1 = 1, kBase0 = 2, kBase1 = 3 };

/// The place on the outline that belongs to an edge point.
struct OutlineMatch {
  OutlinePiece piece;
  int station;                   ///< index of the nearest station, see Outline::stations
  Eigen::Vector3d point_in_cam;  ///< on the cylinder's contour, metres
  Eigen::Vector2d inward;        ///< unit normal of the outline there, pointing into the part
  double distance_px;            ///< of the edge point from the outline, positive inside
};

class Outline {
 public:
  /// None where `outline_arcs` gives none.
  static std::optional<Outline> of(const CameraModel& camera, const PartModel& part, const CylinderPose& pose);

  /// The nearest place of the outline whose normal agrees with the edge point's, within `max_distance_px`.
  [[nodiscard]] std::optional<OutlineMatch> match(const EdgePoint& edge, double max_distance_px) const;

  /// Places spread evenly over each piece, some pixels apart: what share of the outline is seen is counted on them.
  struct Station {
    OutlinePiece piece;
    Eigen::Vector2d position_px;
    double place;  ///< metres along the axis from the centre (sides), angle on the circle in radians (bases)
  };
  [[nodiscard]] const std::vector<Station>& stations() const { return stations_; }

  /// The two sides as image lines, normals pointing into the part.
  [[nodiscard]] const std::array<ImageLine, 2>& sides() const { return sides_; }

  /// Area inside the outline in square pixels, parts outside the image included.
  [[nodiscard]] double area_px() const;

  /// True when the place is inside the outline, at least `margin_px` away from both sides (negative: outside by that).
  [[nodiscard]] bool within(const Eigen::Vector2d& position_px, double margin_px) const;

 private:
  Outline(const CameraModel& camera, const PartModel& part, const CylinderPose& pose, const OutlineArcs& arcs);

  [[nodiscard]] Eigen::Vector2d arc_tangent(int base, double angle) const;
  void add_stations(OutlinePiece piece, double from, double to);
  [[nodiscard]] Eigen::Vector3d point_at(OutlinePiece piece, double place) const;
  [[nodiscard]] std::optional<OutlineMatch> match_side(int side, const EdgePoint& edge, double max_distance_px) const;
  [[nodiscard]] std::optional<OutlineMatch> match_base(int base, const EdgePoint& edge, double max_distance_px) const;

  CameraModel camera_;
  double radius_m_;
  double height_m_;
  CylinderPose pose_;
  OutlineArcs arcs_;
  std::array<ImageLine, 2> sides_;
  std::array<Eigen::Vector3d, 2> touch_;  ///< on each side's line of touch, at the centre's height
  std::array<ImageLine, 2> chords_;  ///< per base, through its two points of touch; the normal points into the part
  std::array<double, 2> arc_turn_;   ///< +1 where the part lies to the left of the arc's tangent (x right, y down)
  std::vector<Station> stations_;
  std::array<int, kOutlinePieces + 1> first_station_;
};

}  // namespace cylpose
