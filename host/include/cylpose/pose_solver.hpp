// The sequential stages: from the edge field of one frame to the pose of every part.
#pragma once

#include <cylpose/camera.hpp>
#include <cylpose/edge_field.hpp>
#include <cylpose/ellipse.hpp>
#include <cylpose/estimator.hpp>
#include <cylpose/line.hpp>
#include <cylpose/part.hpp>
#include <cylpose/pose.hpp>
#include <cylpose/refine.hpp>
#include <cylpose/side_pair.hpp>
#include <string>
#include <vector>

namespace cylpose {

/// What a pose must show to be called `ok`. A pose that fails is `none`, with the test that fired as its reason.
struct CheckOptions {
  /// Share of the predicted outline (inside the image) that edge points support. Occluders lower it; a wrong pose
  /// seldom reaches a third. Range 0..1.
  double min_seen = 0.4;
  /// The same for each of the two sides; a base seen less than this counts as hidden.
  double min_side_seen = 0.2;
  /// Root mean square distance of the supporting points in pixels, where three fourths of the outline are seen; where
  /// fewer are, as much less: what is hidden cannot contradict.
  double max_rms_px = 0.45;
  /// Where the outline is hardly longer than wide (views along the axis), and many things look like that: the same
  /// where all of it is seen.
  double max_blob_rms_px = 0.4;
  /// The same where in addition less of the outline than `min_blob_seen` is seen: then hardly anything else tells a
  /// wrong tilt.
  double max_part_of_blob_rms_px = 0.15;
  double min_blob_seen = 0.75;  ///< share, 0..1
  /// Coloured pixels per pixel of such an outline, separate things elsewhere left out. Above: what is seen is larger.
  double max_blob_fill = 1.1;
  /// Where one base is hidden (seen less than `min_side_seen`), the other one's curvature is all that tells the part's
  /// side from the edge of an occluder that lies along it: root mean square distance of that base's points in pixels;
  /// in pictures whose sides scatter more, 1.5 times theirs.
  double max_lone_base_rms_px = 0.1;
  /// How far both sides may go on beyond a base that is not seen, as a share of the part's length in the picture: what
  /// is longer than the part is not the part (> 0).
  double max_overrun = 0.15;
  /// Share of the edge points inside the outline's band that support it. What an occluder or a second object of the
  /// colour contributes lowers it. Range 0..1.
  double min_explained = 0.4;
  /// Coloured pixels per pixel of the predicted outline. Below: the outline is larger than what was seen.
  double min_fill = 0.35;
  /// Share of a base's rim that must be seen where it is most of the outline (views along the axis): the sides are then
  /// too short to be asked for. Range 0..1.
  double min_rim_seen = 0.8;
  /// How much likelier than any other pose far from it (10 degrees or a fourth of the height) a pose must be by its
  /// residuals, whether the other one passes the tests above or not: the logarithm of the ratio, neighbouring points
  /// that err alike counted as one (> 0). Lower gives more poses, and with badly located edges wrong ones.
  double min_evidence = 6;
  /// What a pose's own covariance may say at most, for what is known worse is of no use as a pose: the standard
  /// deviation of the axis direction in degrees (PoseEstimate::sigma_axis_rad), and of the axis line's distance from
  /// the camera's centre as a share of the part's distance (both > 0). The place along the axis may be unknown: both
  /// ends can be hidden.
  double max_axis_sigma_deg = 7.5;
  double max_line_sigma = 0.02;

  [[nodiscard]] bool is_valid(std::string* why) const;
};

/// Options of all sequential stages.
struct SolveOptions {
  int min_chain_length = 12;       ///< pixels; shorter connected edges are noise. At least 2
  double split_distance_px = 1.2;  ///< where a chain bends more than this from its chord it is cut (> 0)
  int min_segment_length = 10;     ///< points; shorter straight pieces carry no direction. At least 2
  LineOptions line;
  SidePairOptions pair;
  EllipseOptions ellipse;
  RefineOptions refine;
  CheckOptions check;

  [[nodiscard]] bool is_valid(std::string* why) const;
};

/// Solves frames independently of each other; may be used from several threads at once.
class PoseSolver {
 public:
  /// Throws Error(kInput) for an invalid camera, parts or options.
  PoseSolver(CameraModel camera, std::vector<PartModel> parts, SolveOptions options = {});

  /// One estimate per part. `field` must come from a request for the same parts. Fills `trace` where one is given and
  /// appends the stages' times to `times` where given.
  [[nodiscard]] std::vector<PoseEstimate> solve(const EdgeField& field, StageTrace* trace = nullptr,
                                                std::vector<StageTime>* times = nullptr) const;

  [[nodiscard]] const CameraModel& camera() const { return camera_; }
  [[nodiscard]] const std::vector<PartModel>& parts() const { return parts_; }

 private:
  CameraModel camera_;
  std::vector<PartModel> parts_;
  SolveOptions options_;
};

}  // namespace cylpose
