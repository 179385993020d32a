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

/// Of the places on which is counted what share of an outline is seen; short pieces have more, long ones fewer.
inline constexpr double kStationSpacingPx = 3;

/// The place on the outline that belongs to an edge point.
struct OutlineMatch {
  OutlinePiece piece;
  double share;               ///< of the way along a side from base 0 to base 1, 0..1 in pixels; 0 on bases
  Eigen::Vector2d on_circle;  ///< cosine and sine of the angle on a base's circle (OutlineArcs); zero on sides
  Eigen::Vector2d inward;     ///< unit normal of the outline there, pointing into the part
  double distance_px;         ///< of the edge point from where edges of this border are located (curved_border.hpp),
                              ///< positive inside
  EdgeCue cue;                ///< that told where the edge is
};

class Outline {
 public:
  /// None where `outline_arcs` gives none.
  static std::optional<Outline> of(const CameraModel& camera, const PartModel& part, const CylinderPose& pose);

  /// The nearest place of the outline whose normal agrees with the edge point's, within `max_distance_px`. None where a
  /// base bends so much that edges are not located well.
  [[nodiscard]] std::optional<OutlineMatch> match(const EdgePoint& edge, double max_distance_px) const;

  /// The surface point, in metres, that bounds the view at a place on a base; at the end of a side at base 0 or 1.
  [[nodiscard]] Eigen::Vector3d point_on_base(const OutlineMatch& match) const;
  [[nodiscard]] Eigen::Vector3d end_of_side(std::size_t side, std::size_t base) const;

  /// Places spread evenly over each piece, about kStationSpacingPx apart: what share of the outline is seen is counted
  /// on them.
  struct Station {
    OutlinePiece piece;
    double share;  ///< how far along the piece it lies, 0..1 (in pixels on sides, in angle on bases)
    Eigen::Vector2d position_px;
  };
  [[nodiscard]] std::vector<Station> stations() const;
  [[nodiscard]] std::size_t station_count() const;

  /// Of the outline at a station.
  struct Place {
    Eigen::Vector3d point_in_cam;  ///< the surface point, in metres, that bounds the view there
    Eigen::Vector2d inward;        ///< unit normal in the image, pointing into the part
    double curvature;              ///< 1/px; 0 on sides
  };
  [[nodiscard]] Place place_of(const Station& station) const;

  /// How far along its side or base a match lies, 0..1.
  [[nodiscard]] double share_of(const OutlineMatch& match) const;
  /// Index of the station nearest to a match.
  [[nodiscard]] std::size_t station_of(const OutlineMatch& match) const;

  /// The two sides as image lines, normals pointing into the part.
  [[nodiscard]] const std::array<ImageLine, 2>& sides() const { return sides_; }

  /// How far the arc of base 0 or 1 reaches beyond the line through its two points of touch, in pixels.
  [[nodiscard]] double bulge_px(std::size_t base) const;

  /// Area inside the outline in square pixels, parts outside the image included.
  [[nodiscard]] double area_px() const;

  /// True when the place is inside the outline, at least `margin_px` away from both sides (negative: outside by that).
  [[nodiscard]] bool within(const Eigen::Vector2d& position_px, double margin_px) const;

  /// True when the place is outside by more than `margin_px`.
  [[nodiscard]] bool beyond(const Eigen::Vector2d& position_px, double margin_px) const;

 private:
  // The image of a base's circle: middle + (cos a by_cosine + sin a by_sine) / (1 + w . (cos a, sin a)).
  struct CircleImage {
    Eigen::Vector2d middle;
    Eigen::Vector2d by_cosine;
    Eigen::Vector2d by_sine;
    Eigen::Vector2d w;

    struct Place {
      Eigen::Vector2d position;
      Eigen::Vector2d tangent;  // pixels per radian
    };
    [[nodiscard]] Place at(const Eigen::Vector2d& on_circle) const;
    [[nodiscard]] double curvature(const Eigen::Vector2d& on_circle, const Place& place) const;  // 1/px
    struct InCircle {
      Eigen::Vector2d place;
      double squared;             // of the distance from the middle
      Eigen::Vector2d by_cosine;  // its changes per pixel
      Eigen::Vector2d by_sine;
      double on_flat;            // the place along by_sine where the ellipse is flat
      double thickness_squared;  // pixels, of half the ellipse across by_sine

      // Of `squared`, per pixel.
      [[nodiscard]] Eigen::Vector2d slope() const { return 2 * (place.x() * by_cosine + place.y() * by_sine); }
    };
    [[nodiscard]] InCircle in_circle(const Eigen::Vector2d& position_px) const;
    [[nodiscard]] double outside_px(const Eigen::Vector2d& position_px) const;
    [[nodiscard]] std::optional<Eigen::Vector2d> first_guess(const Eigen::Vector2d& position_px, double max_distance_px,
                                                             double cosine_sign) const;
  };

  Outline(const CameraModel& camera, const PartModel& part, const CylinderPose& pose, const OutlineArcs& arcs);

  [[nodiscard]] CircleImage image_of_circle(const CameraModel& camera, std::size_t base) const;
  void count_stations();
  [[nodiscard]] double angle_at(std::size_t base, double share) const;
  [[nodiscard]] Eigen::Vector2d cut_to_arc(std::size_t base, const Eigen::Vector2d& on_circle) const;
  [[nodiscard]] std::optional<OutlineMatch> match_side(std::size_t side, const EdgePoint& edge,
                                                       double max_distance_px) const;
  [[nodiscard]] std::optional<OutlineMatch> match_base(std::size_t base, const EdgePoint& edge,
                                                       double max_distance_px) const;

  double radius_m_;
  OutlineArcs arcs_;
  std::array<std::array<Eigen::Vector3d, 2>, 2> side_ends_;  ///< per side its ends at base 0 and base 1
  std::array<ImageLine, 2> sides_;
  std::array<Eigen::Vector2d, 2> side_from_;   ///< pixel of the end at base 0
  std::array<Eigen::Vector2d, 2> side_along_;  ///< from there to the other end, divided by the length squared
  std::array<CircleImage, 2> circles_;
  std::array<ImageLine, 2> chords_;  ///< per base, through its two points of touch; the normal points into the part
  std::array<Eigen::Vector2d, 2> arc_middle_;  ///< cosine and sine of the angle halfway along each arc
  std::array<Eigen::Vector2d, 2> arc_half_;    ///< cosine and sine of half its span
  std::array<double, 2> arc_turn_;             ///< +1 where the part lies to the left of the tangent (x right, y down)
  std::array<int, kOutlinePieces> stations_of_;  ///< how many stations each piece has
};

}  // namespace cylpose
