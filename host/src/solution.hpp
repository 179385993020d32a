// A hypothesis brought to the edges, and what speaks for and against it.
#pragma once

#include <cylpose/camera.hpp>
#include <cylpose/contour.hpp>
#include <cylpose/cylinder.hpp>
#include <cylpose/ellipse.hpp>
#include <cylpose/outline.hpp>
#include <cylpose/part.hpp>
#include <cylpose/pose.hpp>
#include <cylpose/pose_solver.hpp>
#include <cylpose/refine.hpp>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace cylpose {

struct Solution {
  PoseEstimate estimate;             ///< the pose, whatever the status; kNone with the self-check's test that it failed
  bool is_end_on = false;            ///< a base is all that shows
  bool shows_a_rim = false;          ///< a base's rim is most of what shows
  bool is_blob = false;              ///< the outline is hardly longer than wide
  bool shows_sides = false;          ///< both are seen over more than the width: no base hides them
  bool is_telling = false;           ///< neither a box nor a ball has such an outline
  bool leaves_things = false;        ///< much of what has the part's colour is elsewhere
  double rating = 0;                 ///< of how much is seen and explained, and how tightly; 1 would be perfect
  std::vector<double> residuals_px;  ///< of the judging points; infinite for those that do not belong to the outline
  double scatter_px = 0;             ///< robust standard deviation of those that do: a few far off do not move it
  double unseen = 0;                 ///< places of the outline where no judging point is, as a number of points
  double clumping = 1;               ///< how many neighbouring points err alike: so many count as one
};

[[nodiscard]] PoseEstimate no_pose(std::string reason);

/// Judges the hypotheses of one part in one frame. Keeps references: what it is made from must outlive it.
class Judge {
 public:
  /// Edge points by which solutions are compared.
  static constexpr std::size_t kPointsToJudge = 400;
  /// What a point that does not belong to the outline costs: as much as one that is three standard deviations off it.
  static constexpr double kOutlierCost = 4.5;
  /// By so much differences of misfits are divided at most, for what neighbouring points have in common.
  static constexpr double kMostDistrust = 48;

  /// `chains` index `points`.
  Judge(const CameraModel& camera, const PartModel& part, const SolveOptions& options, const RegionStatistics& region,
        const std::vector<EdgePoint>& points, const std::vector<Chain>& chains);

  /// Refines the pose on all edge points of its outline. None where that leads nowhere.
  [[nodiscard]] std::optional<Solution> refined(const CoarsePose& coarse) const;

  /// Takes the ellipse for the near base that hides all the rest. None where it cannot be that.
  [[nodiscard]] std::optional<Solution> end_on(const FittedEllipse& base) const;

  /// Negative logarithm of the likelihood of the judging points, the outline's points `sigma_px` off it and others
  /// anywhere.
  [[nodiscard]] double misfit(const Solution& solution, double sigma_px) const;

  /// How much likelier `a` is than `b`: the logarithm of the ratio. Negative where `b` is likelier.
  [[nodiscard]] double evidence(const Solution& a, const Solution& b, double sigma_px) const;

 private:
  // So many neighbours may err alike, and what they have in common may be so much larger than it seems.
  static constexpr int kBlock = 16;
  static constexpr double kMaxDistrust = 3;
  static_assert(kBlock * kMaxDistrust == kMostDistrust);

  // What the judging points say of an outline, one after the other along the chains.
  class Hearing {
   public:
    void matched(double distance_px);
    enum class Place { kInside, kAlong, kBeyond, kElsewhere };
    void unmatched(Place place);
    [[nodiscard]] double clumping() const;
    [[nodiscard]] double scatter_px() const;  // 1.4826 times the median distance; infinite where nothing matched
    [[nodiscard]] int matched_count() const { return count_; }

    int clutter = 0;    // inside, but not on the outline
    int beyond = 0;     // outside, but near
    int elsewhere = 0;  // clearly outside
    std::vector<double> residuals_px;

   private:
    int count_ = 0;
    double squares_ = 0;
    int in_block_ = 0;
    double block_sum_ = 0;
    int blocks_ = 0;
    double block_squares_ = 0;
  };

  // Coloured pixels, without those of separate things elsewhere: `is_elsewhere` says which points are.
  [[nodiscard]] double colored_px(const std::function<bool(const EdgePoint&)>& is_elsewhere) const;

  // Fills in the share explained, rating and misfit, and lets the tests that all views share decide.
  void judge(Solution& solution, Hearing hearing, double area_px, double colored_px) const;

  const CameraModel& camera_;
  const PartModel& part_;
  const SolveOptions& options_;
  const RegionStatistics& region_;
  const std::vector<EdgePoint>& points_;
  const std::vector<Chain>& chains_;
  std::vector<EdgePoint> judges_;
};

}  // namespace cylpose
