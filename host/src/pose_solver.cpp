#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cylpose/axial.hpp>
#include <cylpose/contour.hpp>
#include <cylpose/error.hpp>
#include <cylpose/outline.hpp>
#include <cylpose/pose_solver.hpp>
#include <optional>

#include "option_check.hpp"
#include "stage_clock.hpp"

namespace cylpose {
namespace {

constexpr int kMaxCandidatesPerPair = 3;
// Hypotheses that are refined; the others are only compared by how many edge points they explain.
constexpr std::size_t kMaxRefined = 3;
// Edge points by which hypotheses are compared.
constexpr std::size_t kPointsToCompare = 200;
// A solution rated higher leaves nothing for another hypothesis to explain.
constexpr double kClearlyRight = 0.7;
// Edge points this far inside the outline that do not belong to it are clutter.
constexpr double kClutterMarginPx = 3;

struct Hypothesis {
  CylinderPose pose;
  int explained;
};

struct Solution {
  RefinedPose refined;
  double seen;       // share of the whole outline
  double explained;  // share of the edge points in the outline that support it
  double fill;       // coloured pixels per pixel of the outline
  std::array<ImageLine, 2> sides;
};

int count_explained(const Outline& outline, std::span<const EdgePoint> points, double gate_px) {
  return static_cast<int>(
      std::count_if(points.begin(), points.end(), [&](const EdgePoint& p) { return outline.match(p, gate_px); }));
}

// The outline's area inside the image, taken to be the share of its stations that lie there.
double visible_area(const CameraModel& camera, const Outline& outline) {
  int inside = 0;
  for (const auto& station : outline.stations()) {
    const auto& p = station.position_px;
    inside += p.x() >= 0 && p.y() >= 0 && p.x() < camera.width && p.y() < camera.height ? 1 : 0;
  }
  return outline.area_px() * inside / static_cast<double>(outline.stations().size());
}

class PartSolver {
 public:
  PartSolver(const CameraModel& camera, const PartModel& part, const SolveOptions& options, const PartEdges& field,
             StageClock& clock)
      : camera_(camera), part_(part), options_(options), field_(field), clock_(clock) {}

  PoseEstimate solve(PartTrace* trace) {
    find_lines_in_edges(trace);
    const std::vector<SidePair> pairs = rank_side_pairs(camera_, part_, field_.region, lines_, options_.pair);
    const std::vector<Hypothesis> hypotheses = hypothesise(pairs);
    clock_.lap("pose");
    if (field_.edges.empty()) return none("no pixel of the part's colour");
    if (lines_.size() < 2) return none(fmt::format("{} straight edges found, two are needed", lines_.size()));
    if (hypotheses.empty()) return none("no two edges can be the sides of this cylinder");

    std::optional<Solution> best;
    for (const Hypothesis& hypothesis : hypotheses) {
      auto solution = refined(hypothesis);
      if (solution && (!best || rating(*solution) > rating(*best))) best = std::move(solution);
      if (best && rating(*best) > kClearlyRight) break;
    }
    PoseEstimate estimate = best ? checked(*best) : none("no pose explains the edges");
    clock_.lap("refinement");
    return estimate;
  }

 private:
  static PoseEstimate none(std::string reason) {
    PoseEstimate estimate;
    estimate.reason = std::move(reason);
    return estimate;
  }

  void find_lines_in_edges(PartTrace* trace) {
    const std::vector<EdgePixel> edges = with_hysteresis(field_.edges);
    points_ = edge_points(camera_, edges);
    clock_.lap("hysteresis");
    const std::vector<Chain> chains = extract_chains(edges, options_.min_chain_length);
    clock_.lap("contours");
    const std::vector<Chain> segments =
        split_where_bent(chains, points_, options_.split_distance_px, options_.min_segment_length);
    lines_ = find_lines(points_, segments, options_.line);
    clock_.lap("lines");
    if (trace != nullptr) {
      fill_trace(*trace, chains, segments);
      clock_.skip();
    }
  }

  void fill_trace(PartTrace& trace, const std::vector<Chain>& chains, const std::vector<Chain>& segments) const {
    const auto positions = [&](const Chain& chain) {
      std::vector<Eigen::Vector2d> result;
      result.reserve(chain.size());
      for (const int i : chain) result.push_back(points_[static_cast<std::size_t>(i)].position_px);
      return result;
    };
    trace.mask = field_.mask;
    for (const EdgePoint& point : points_) trace.edges.push_back(point.position_px);
    for (const Chain& chain : chains) trace.chains.push_back(positions(chain));
    for (const Chain& segment : segments) trace.segments.push_back(positions(segment));
    for (const FittedLine& line : lines_) trace.lines.push_back(line.line);
  }

  // The poses worth refining: for every pair of sides its places along the axis, by the edge points that they explain.
  std::vector<Hypothesis> hypothesise(const std::vector<SidePair>& pairs) const {
    const std::vector<EdgePoint> few = thinned(points_, kPointsToCompare);
    std::vector<Hypothesis> hypotheses;
    for (const SidePair& pair : pairs) {
      for (const CylinderPose& pose :
           candidate_centers(camera_, part_, pair.axis, points_, field_.region, kMaxCandidatesPerPair)) {
        if (const auto outline = Outline::of(camera_, part_, pose)) {
          hypotheses.push_back({pose, count_explained(*outline, few, options_.refine.first_gate_px)});
        }
      }
    }
    std::stable_sort(hypotheses.begin(), hypotheses.end(),
                     [](const Hypothesis& a, const Hypothesis& b) { return a.explained > b.explained; });
    if (hypotheses.size() > kMaxRefined) hypotheses.resize(kMaxRefined);
    return hypotheses;
  }

  std::optional<Solution> refined(const Hypothesis& hypothesis) const {
    auto pose = refine(camera_, part_, hypothesis.pose, points_, options_.refine);
    if (!pose) return std::nullopt;
    const auto outline = Outline::of(camera_, part_, pose->pose);
    if (!outline) return std::nullopt;

    int clutter = 0;
    for (const EdgePoint& point : points_) {
      if (outline->within(point.position_px, kClutterMarginPx) &&
          !outline->match(point, options_.refine.final_gate_px)) {
        ++clutter;
      }
    }
    double hits = 0;
    int stations = 0;
    for (std::size_t piece = 0; piece < kOutlinePieces; ++piece) {
      hits += pose->piece_seen[piece] * pose->piece_stations[piece];
      stations += pose->piece_stations[piece];
    }
    const double area = visible_area(camera_, *outline);
    Solution solution{*pose, 0, 0, 0, outline->sides()};
    solution.seen = hits / std::max(1, stations);
    solution.explained = static_cast<double>(pose->support) / (pose->support + clutter);
    solution.fill = area > 0 ? static_cast<double>(field_.region.m00) / area : 0;
    return solution;
  }

  // Which of two refined hypotheses is the better one: both much seen and much explained, then a tight fit.
  static double rating(const Solution& solution) {
    return solution.seen * solution.explained / (1 + solution.refined.rms_px);
  }

  PoseEstimate checked(const Solution& solution) const {
    const CheckOptions& check = options_.check;
    const RefinedPose& refined = solution.refined;
    const double side_seen = std::min(refined.piece_seen[kSide0], refined.piece_seen[kSide1]);
    if (solution.seen < check.min_seen) {
      return none(fmt::format("only {:.0f} % of the outline seen", 100 * solution.seen));
    }
    if (side_seen < check.min_side_seen) return none(fmt::format("only {:.0f} % of a side seen", 100 * side_seen));
    if (refined.rms_px > check.max_rms_px) {
      return none(fmt::format("edges {:.2f} px off the outline", refined.rms_px));
    }
    for (const std::size_t lone_base : {std::size_t{kBase0}, std::size_t{kBase1}}) {
      const std::size_t other_base = kBase0 + kBase1 - lone_base;
      const double rms_px = refined.piece_rms_px[lone_base];
      if (refined.piece_seen[other_base] < check.min_side_seen && rms_px > check.max_lone_base_rms_px) {
        return none(fmt::format("the only base seen fits badly ({:.2f} px)", rms_px));
      }
    }
    if (solution.explained < check.min_explained) {
      return none(fmt::format("outline explains only {:.0f} % of the edges in it", 100 * solution.explained));
    }
    if (solution.fill < check.min_fill) {
      return none(fmt::format("only {:.0f} % of the outline has the part's colour", 100 * solution.fill));
    }

    PoseEstimate estimate;
    estimate.status = PoseStatus::kOk;
    estimate.pose = with_fixed_sign(refined.pose);
    estimate.covariance = refined.covariance;
    estimate.rms_px = refined.rms_px;
    estimate.support = refined.support;
    estimate.seen = solution.seen;
    estimate.sides = solution.sides;
    return estimate;
  }

  const CameraModel& camera_;
  const PartModel& part_;
  const SolveOptions& options_;
  const PartEdges& field_;
  StageClock& clock_;
  std::vector<EdgePoint> points_;
  std::vector<FittedLine> lines_;
};

}  // namespace

bool CheckOptions::is_valid(std::string* why) const {
  return require_share(min_seen, "min_seen", why) && require_share(min_side_seen, "min_side_seen", why) &&
         require_positive(max_rms_px, "max_rms_px", why) &&
         require_positive(max_lone_base_rms_px, "max_lone_base_rms_px", why) &&
         require_share(min_explained, "min_explained", why) && require_share(min_fill, "min_fill", why);
}

bool SolveOptions::is_valid(std::string* why) const {
  return require_at_least(min_chain_length, 2, "min_chain_length", why) &&
         require_positive(split_distance_px, "split_distance_px", why) &&
         require_at_least(min_segment_length, 2, "min_segment_length", why) && line.is_valid(why) &&
         pair.is_valid(why) && refine.is_valid(why) && check.is_valid(why);
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
