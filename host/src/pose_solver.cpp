#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cylpose/axial.hpp>
#include <cylpose/base_pose.hpp>
#include <cylpose/contour.hpp>
#include <cylpose/ellipse.hpp>
#include <cylpose/error.hpp>
#include <cylpose/outline.hpp>
#include <cylpose/pose_solver.hpp>
#include <functional>
#include <optional>

#include "contest.hpp"
#include "loop.hpp"
#include "option_check.hpp"
#include "stage_clock.hpp"

namespace cylpose {
namespace {

constexpr int kMaxCandidatesPerPair = 3;
// Edge points by which places along the axis are found.
constexpr std::size_t kPointsToPlace = 500;
// A pair of sides that explains more of the edges than this share leaves nothing to other pairs.
constexpr double kNearlyAll = 0.95;

class PartSolver {
 public:
  PartSolver(const CameraModel& camera, const PartModel& part, const SolveOptions& options, const PartEdges& field,
             StageClock& clock)
      : camera_(camera), part_(part), options_(options), field_(field), clock_(clock) {}

  PoseEstimate solve(PartTrace* trace) {
    find_lines_in_edges(trace);
    if (field_.edges.empty()) return no_pose("no pixel of the part's colour");
    Contest contest(camera_, part_, options_, field_.region, points_, chains_);
    std::vector<Hypothesis> hypotheses = from_sides(contest);
    clock_.lap("pose");
    contest.enter(std::move(hypotheses));
    if (!contest.is_decided() && !contest.shows_sides()) enter_bases(contest);
    contest.dismiss_other_things();
    contest.enter_mirror_image();
    PoseEstimate estimate = contest.verdict();
    clock_.lap("refinement");
    return estimate;
  }

 private:
  void find_lines_in_edges(PartTrace* trace) {
    const std::vector<EdgePixel> edges = with_hysteresis(field_.edges);
    points_ = edge_points(camera_, edges);
    clock_.lap("hysteresis");
    chains_ = extract_chains(edges, options_.min_chain_length);
    clock_.lap("contours");
    const std::vector<Chain> segments =
        split_where_bent(chains_, points_, options_.split_distance_px, options_.min_segment_length);
    lines_ = find_lines(points_, segments, options_.line);
    clock_.lap("lines");
    if (trace != nullptr) {
      fill_trace(*trace, segments);
      clock_.skip();
    }
  }

  void fill_trace(PartTrace& trace, const std::vector<Chain>& segments) const {
    const auto positions = [&](const Chain& chain) {
      std::vector<Eigen::Vector2d> result;
      result.reserve(chain.size());
      for (const int i : chain) result.push_back(points_[static_cast<std::size_t>(i)].position_px);
      return result;
    };
    trace.mask = field_.mask;
    for (const EdgePoint& point : points_) trace.edges.push_back(point.position_px);
    for (const Chain& chain : chains_) trace.chains.push_back(positions(chain));
    for (const Chain& segment : segments) trace.segments.push_back(positions(segment));
    for (const FittedLine& line : lines_) trace.lines.push_back(line.line);
  }

  // For every pair of sides its places along the axis.
  std::vector<Hypothesis> from_sides(const Contest& contest) const {
    const std::vector<EdgePoint> some = thinned(points_, kPointsToPlace);
    std::vector<Hypothesis> hypotheses;
    double most = 0;
    for (const SidePair& pair : rank_side_pairs(camera_, part_, field_.region, lines_, options_.pair)) {
      for (const CylinderPose& pose :
           candidate_centers(camera_, part_, pair.axis, some, field_.region, kMaxCandidatesPerPair)) {
        if (const auto hypothesis = contest.hypothesis(pose)) {
          hypotheses.push_back(*hypothesis);
          most = std::max(most, hypothesis->explained);
        }
      }
      if (most > kNearlyAll) break;
    }
    return hypotheses;
  }

  // Views along the axis: the sides are short or not there, but a base shows nearly all of its rim.
  void enter_bases(Contest& contest) const {
    const std::vector<FittedEllipse> ellipses = find_ellipses(points_, chains_, options_.ellipse);
    contest.enter_end_on(ellipses);
    std::vector<CylinderPose> poses = poses_from_bases(camera_, part_, ellipses);
    for (const RegionStatistics& blob : blobs()) {
      const std::vector<CylinderPose> rough = poses_from_blob(camera_, part_, blob);
      poses.insert(poses.end(), rough.begin(), rough.end());
    }
    contest.enter(poses);
  }

  // All of the part's colour, which a bar may divide, and where there are several things of it the largest ones.
  [[nodiscard]] std::vector<RegionStatistics> blobs() const {
    constexpr std::size_t kMaxThings = 2;
    std::vector<RegionStatistics> things;
    for (const Chain& chain : chains_) {
      if (const auto thing = region_in_loop(points_, chain)) things.push_back(*thing);
    }
    if (things.size() < 2) things.clear();
    std::ranges::stable_sort(things, std::greater<>{}, &RegionStatistics::m00);
    if (things.size() > kMaxThings) things.resize(kMaxThings);
    if (field_.region.m00 > 0) things.insert(things.begin(), field_.region);
    return things;
  }

  const CameraModel& camera_;
  const PartModel& part_;
  const SolveOptions& options_;
  const PartEdges& field_;
  StageClock& clock_;
  std::vector<EdgePoint> points_;
  std::vector<Chain> chains_;
  std::vector<FittedLine> lines_;
};

}  // namespace

bool CheckOptions::is_valid(std::string* why) const {
  return require_share(min_seen, "min_seen", why) && require_share(min_side_seen, "min_side_seen", why) &&
         require_positive(max_rms_px, "max_rms_px", why) && require_positive(max_blob_rms_px, "max_blob_rms_px", why) &&
         require_positive(max_blob_fill, "max_blob_fill", why) &&
         require_positive(max_lone_base_rms_px, "max_lone_base_rms_px", why) &&
         require_positive(max_overrun, "max_overrun", why) && require_share(min_explained, "min_explained", why) &&
         require_share(min_fill, "min_fill", why) && require_share(min_rim_seen, "min_rim_seen", why) &&
         require_positive(min_evidence, "min_evidence", why) &&
         require_positive(max_axis_sigma_deg, "max_axis_sigma_deg", why) &&
         require_positive(max_line_sigma, "max_line_sigma", why);
}

bool SolveOptions::is_valid(std::string* why) const {
  return require_at_least(min_chain_length, 2, "min_chain_length", why) &&
         require_positive(split_distance_px, "split_distance_px", why) &&
         require_at_least(min_segment_length, 2, "min_segment_length", why) && line.is_valid(why) &&
         pair.is_valid(why) && ellipse.is_valid(why) && refine.is_valid(why) && check.is_valid(why);
}

PoseSolver::PoseSolver(CameraModel camera, std::vector<PartModel> parts, SolveOptions options)
    : camera_(std::move(camera)), parts_(std::move(parts)), options_(options) {
  std::string why;
  if (!camera_.is_valid(&why)) throw Error(ErrorKind::kInput, "camera: " + why);
  for (const PartModel& part : parts_) {
    if (!part.is_valid(&why)) throw Error(ErrorKind::kInput, "part '" + part.name + "': " + why);
  }
  if (!options_.is_valid(&why)) throw Error(ErrorKind::kInput, "solve options: " + why);
}

std::vector<PoseEstimate> PoseSolver::solve(const EdgeField& field, StageTrace* trace,
                                            std::vector<StageTime>* times) const {
  if (field.parts.size() != parts_.size()) {
    throw Error(ErrorKind::kInput,
                fmt::format("edge field of {} parts given to a solver of {} parts", field.parts.size(), parts_.size()));
  }
  if (trace != nullptr) trace->parts.assign(parts_.size(), {});
  StageClock clock;
  std::vector<PoseEstimate> estimates;
  estimates.reserve(parts_.size());
  for (std::size_t i = 0; i < parts_.size(); ++i) {
    PartSolver solver(camera_, parts_[i], options_, field.parts[i], clock);
    estimates.push_back(solver.solve(trace != nullptr ? &trace->parts[i] : nullptr));
  }
  if (times != nullptr) times->insert(times->end(), clock.times().begin(), clock.times().end());
  return estimates;
}

}  // namespace cylpose
