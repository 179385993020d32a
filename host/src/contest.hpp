// Hypotheses of one part in one frame against each other: which one is reported, and whether any may be.
#pragma once

#include <cylpose/camera.hpp>
#include <cylpose/cylinder.hpp>
#include <cylpose/ellipse.hpp>
#include <cylpose/part.hpp>
#include <cylpose/pose.hpp>
#include <cylpose/pose_solver.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "solution.hpp"

namespace cylpose {

struct Hypothesis {
  CylinderPose pose;
  double explained;  ///< share of the edge points near its outline
};

/// Keeps references: what it is made from must outlive it.
class Contest {
 public:
  Contest(const CameraModel& camera, const PartModel& part, const SolveOptions& options, const RegionStatistics& region,
          const std::vector<EdgePoint>& points, const std::vector<Chain>& chains);

  /// None for a pose that has no outline.
  [[nodiscard]] std::optional<Hypothesis> hypothesis(const CylinderPose& pose) const;

  /// Refines those that explain most, each place once, until one is clearly right.
  void enter(std::vector<Hypothesis> hypotheses);
  void enter(std::span<const CylinderPose> poses);

  /// Enters the views along the axis in which one of the ellipses is all that shows.
  void enter_end_on(std::span<const FittedEllipse> ellipses);

  /// Beside an outline that only the part can have, a box or a ball raises no doubt.
  void dismiss_other_things();

  /// Enters the leader's mirror image, the axis reflected in the plane across the line of sight, where the outlines
  /// differ so little that the leader's residuals may hide it: only perspective tells one from the other.
  void enter_mirror_image();

  /// True when a solution leaves nothing for another hypothesis to explain.
  [[nodiscard]] bool is_decided() const;

  /// True when the best solution passes the self-check and shows its sides, and little of the part's colour is
  /// elsewhere, so that no view of a base alone can be meant.
  [[nodiscard]] bool shows_sides() const;

  /// The best solution; `none` with the reason when there is none, when it fails the self-check, or when one far from
  /// it explains the outline as well (CheckOptions::min_evidence), whether that passes the self-check or not. Of two
  /// that are at most 20 degrees and a fourth of the height (or twice CheckOptions::max_line_sigma) apart the pose
  /// midway, its covariance covering both.
  [[nodiscard]] PoseEstimate verdict() const;

 private:
  [[nodiscard]] double edge_sigma_px() const;
  [[nodiscard]] bool is_one_answer(const Solution& a, const Solution& b) const;
  [[nodiscard]] bool may_lie_midway(const Solution& a, const Solution& b) const;
  [[nodiscard]] const Solution* leader() const;
  [[nodiscard]] const Solution* preferred() const;
  [[nodiscard]] std::optional<std::string> base_alone_instead_of(const Solution& chosen, double sigma_px) const;
  [[nodiscard]] bool is_hopeless(const CoarsePose& coarse) const;
  void finish(const CoarsePose& coarse);  // refines it unless that was done

  const CameraModel& camera_;
  const PartModel& part_;
  const SolveOptions& options_;
  Judge judge_;
  std::vector<EdgePoint> to_compare_;
  std::vector<EdgePoint> to_come_near_;
  std::vector<CoarsePose> finished_;
  std::vector<Solution> solutions_;
};

}  // namespace cylpose
