// The method of the master's thesis that cylpose grew out of, kept as the baseline that everything is measured against:
// its algorithms 5.1 to 5.5 on OpenCV, its printed slips corrected. docs/thesis.md explains it and lists the slips.
//
// The stages stand here one by one, so that each can be tested, shown and timed alone. Three coordinate systems occur:
// - frame: pixels of the image;
// - ideal: pixels of a camera with one focal length and no distortion that looks through the same centre, relative to
//   its principal point (the thesis assumes such images; thesis_focal_px);
// - local: ideal, but relative to the region's mean, so that the normal length of a line does not depend on how far the
//   cylinder is from the principal point.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cylpose/estimator.hpp>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace cylpose {

/// Thresholds of the method. Where the thesis gives a value, it is the default.
struct ThesisOptions {
  /// By how much of its size the last bounding box grows to become the next search region (5.1.1.2: a fourth). At least
  /// 0; more follows faster motion and costs time.
  double search_growth = 0.25;
  /// Connected pixels that an edge must exceed and each piece cut from it must reach (5.1.1.3: 30; 40 on camera
  /// images). At least 2; more drops noise and short sides.
  int min_edge_size = 30;
  /// Distance from the chord, in pixels, from which an edge is cut there. The thesis gives none. Whole-pixel steps stay
  /// below 1, so smaller values shatter sides; larger ones leave part of the base's arc on the side. Above 0.
  double max_chord_distance_px = 2.0;
  /// Mean squared distance, in square pixels, below which a piece counts as straight (5.1.1.3: 1). Above 0.
  double max_squared_error_px2 = 1.0;
  /// The same for lines within `upright_tolerance_rad` of an image axis, as a factor (algorithm 5.4: 2). At least 1.
  double upright_error_factor = 2.0;
  /// The thesis gives none: 1 degree, a step of one pixel in 57. Within 0..pi/4.
  double upright_tolerance_rad = 0.0175;
  /// Two lines are one if they differ by no more than these two in direction and in normal length ("a small
  /// difference"; 0.1 rad and 15 px on camera images, which would make the two sides of a distant cylinder one). Above
  /// 0; the length must stay below the width of the cylinder in the image.
  double equal_angle_rad = 0.05;
  double equal_distance_px = 3.0;
  /// Largest angle between a side and the region's principal orientation (3.3.1: 35 degrees). Within 0..pi/2.
  double max_angle_to_region_rad = 0.6109;
  /// The second line is "significantly" better supported than the third from this ratio on. The thesis gives none. At
  /// least 1; larger lets the angle decide more often.
  double clear_support_ratio = 1.5;

  [[nodiscard]] bool is_valid(std::string* why) const;
};

/// A straight line in the normal form of equations 3.7 and 3.8: cos(rho) x + sin(rho) y = delta.
struct ThesisLine {
  double rho_rad = 0;
  double delta_px = 0;
  double squared_error_px2 = 0;         ///< mean squared distance of the points that it was fitted to
  std::vector<Eigen::Vector2d> points;  ///< the points it stands for; their number is its support

  [[nodiscard]] Eigen::Vector2d normal() const;
};

/// The elements [begin, end) of an edge.
struct EdgePiece {
  std::size_t begin;
  std::size_t end;
  friend bool operator==(const EdgePiece&, const EdgePiece&) = default;
};

// --- Algorithm 5.3, createEdgeImage ----------------------------------------------------------------------------------

/// Pixels of `search` (inside the image) in the part's hue range and above its floors, by OpenCV's 8-bit HSV, whose hue
/// has steps of 2 degrees. Grey images carry no hue: the value floor alone decides.
[[nodiscard]] Mask thesis_gate(const ImageView& image, const Roi& search, const PartModel& part);

/// 3x3 erosion, then dilation. Pixels outside the mask neither erode nor grow.
void thesis_morphology(Mask* mask);

/// Bounding box and moments (equation 5.1) of the mask.
[[nodiscard]] RegionStatistics thesis_statistics(const Mask& mask);

/// Canny edges of the binary mask, cropped to the bounding box and the two pixels around it that Canny looks at. Where
/// the mask runs out of its own area (the image's border) there is no edge.
[[nodiscard]] Mask thesis_canny(const Mask& mask, const Roi& box);

// --- Algorithms 5.1, 5.2 and 5.4, findLineCandidates -----------------------------------------------------------------

/// Algorithm 5.1: connected edge pixels in order, in frame pixels; only edges of more than `min_size` pixels.
[[nodiscard]] std::vector<std::vector<Eigen::Vector2d>> thesis_edges(const Mask& edge_image, int min_size);

/// Algorithm 5.2 (Ramer, Douglas, Peucker): the pieces of the edge that stay closer than `max_distance_px` to their
/// chord. Neighbouring pieces share the element at the cut; pieces of fewer than `min_size` elements are dropped.
[[nodiscard]] std::vector<EdgePiece> thesis_pieces(std::span<const Eigen::Vector2d> edge, int min_size,
                                                   double max_distance_px);

/// Linear regression (equation 3.4) over the coordinate in which the points spread more: y on x for flat lines, x on y
/// for steep ones. Requires at least one point; points all in one place give a horizontal line.
[[nodiscard]] ThesisLine thesis_fitted_line(std::vector<Eigen::Vector2d> points);

/// The error test of algorithm 5.4.
[[nodiscard]] bool is_straight(const ThesisLine& line, const ThesisOptions& options);

/// Joins equal lines, their parameters weighted by support, best supported first.
[[nodiscard]] std::vector<ThesisLine> thesis_combined(std::vector<ThesisLine> lines, const ThesisOptions& options);

/// The two sides among lines sorted by support, those that differ from the region's orientation left out. None if fewer
/// than two are left; `why` then says so.
[[nodiscard]] std::optional<std::array<ThesisLine, 2>> thesis_candidates(const std::vector<ThesisLine>& lines,
                                                                         const RegionStatistics& region,
                                                                         const ThesisOptions& options,
                                                                         std::string* why);

// --- Algorithm 5.5, estimateCylinder ---------------------------------------------------------------------------------

/// Focal length of the ideal camera: the geometric mean of fx and fy, which is f where they are equal.
[[nodiscard]] double thesis_focal_px(const CameraModel& camera);

/// Frame pixels to ideal pixels.
[[nodiscard]] std::vector<Eigen::Vector2d> thesis_ideal_points(const CameraModel& camera,
                                                               std::span<const Eigen::Vector2d> pixels);

/// The pose from both sides and the region's mean, all in ideal pixels (equations 2.17 and 3.9 to 3.25). The axis'
/// direction is exact for exact lines; the axis lies too near by about r^2 / (2 D) at the distance D. The sign of the
/// axis is fixed. None, with the reason in `why`, for lines that give no cylinder in front of the camera.
[[nodiscard]] std::optional<CylinderPose> thesis_pose_from_lines(const ImageLine& first, const ImageLine& second,
                                                                 const Eigen::Vector2d& mean_px, double focal_px,
                                                                 double radius_m, std::string* why);

/// Covariance as in PoseEstimate. The thesis has none; this is what whole pixels do to the lines, through the pose, and
/// a centre anywhere along the height (variance height^2 / 12). A line's offset has the variance 1/12 px^2, its turn
/// that of a rod with both ends rounded to whole pixels, however many pixels lie between. `sides` in ideal pixels. The
/// method's bias is not in it. None where the pose is on the verge of having none.
[[nodiscard]] std::optional<Eigen::Matrix<double, 6, 6>> thesis_covariance(const std::array<ThesisLine, 2>& sides,
                                                                           const Eigen::Vector2d& mean_px,
                                                                           double focal_px, const PartModel& part);

/// The whole method for a stream of images. Throws Error(kInput) for an invalid camera, parts or options.
[[nodiscard]] std::unique_ptr<Estimator> make_thesis_estimator(const CameraModel& camera,
                                                               const std::vector<PartModel>& parts,
                                                               const ThesisOptions& options = {});

}  // namespace cylpose
