#include "solution.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cylpose/axial.hpp>
#include <cylpose/base_pose.hpp>
#include <cylpose/refine.hpp>
#include <iterator>
#include <limits>
#include <numbers>
#include <utility>

#include "end_check.hpp"
#include "loop.hpp"
#include "robust_sigma.hpp"

namespace cylpose {
namespace {

// Edge points this far outside belong to something else. That may be the part as well where it has more edges than this
// share of those on an outline that other things have, too; and than this multiple of those on any outline.
constexpr double kMaxBeyond = 0.1;
constexpr double kElsewherePx = 8;
constexpr double kMaxElsewhere = 0.25;
constexpr double kMaxElsewhereAtAll = 2;
// An outline's place that is not seen counts against a pose, but less than an edge that it does not explain: whatever
// hides the one shows the other.
constexpr double kUnseenWeight = 0.25;
// A lone base whose points err by more than this multiple of what the sides' points do is an occluder's edge.
constexpr double kMaxLoneBaseOfSides = 1.5;
// And so is one that makes the sides fit worse by more than this: it tilts the pose. Sides that fit better than that
// many pixels are not bent.
constexpr double kMaxSidesWithLoneBase = 1.5;
constexpr double kStraightSidesPx = 0.05;
// An outline of which more is seen is no part of something larger.
constexpr double kWhole = 0.95;
// Of a base that is all that shows: less leaves its size open where the edges fit badly.
constexpr double kWholeRim = 0.9;
// An outline of which this much is seen could contradict a pose as well as a whole one.
constexpr double kWellSeen = 0.75;
// A rating above this needs all of the outline, seen and well explained: nothing else looks like that.
constexpr double kClearlyRight = 0.85;
// A base whose rim is more than this share of the outline: the view is along the axis, the sides are short.
constexpr double kMinRimShare = 0.6;

// The chains' points one after the other, thinned to about `at_most`.
std::vector<EdgePoint> along_chains(const std::vector<EdgePoint>& points, const std::vector<Chain>& chains,
                                    std::size_t at_most) {
  std::vector<EdgePoint> in_order;
  for (const Chain& chain : chains) {
    for (const int i : chain) in_order.push_back(points[static_cast<std::size_t>(i)]);
  }
  return thinned(in_order, at_most);
}

double width_px(const CameraModel& camera, const PartModel& part, const CylinderPose& pose) {
  return 2 * part.radius_m * camera.fx / pose.center_in_cam.z();
}

// How much is seen of the side of which less is seen, in widths of the outline.
double side_seen_in_widths(const CameraModel& camera, const PartModel& part, const Outline& outline,
                           const RefinedPose& refined) {
  double least_px = std::numeric_limits<double>::infinity();
  for (const std::size_t side : {std::size_t{kSide0}, std::size_t{kSide1}}) {
    const double length_px =
        (ideal_pixel(camera, outline.end_of_side(side, 0)) - ideal_pixel(camera, outline.end_of_side(side, 1))).norm();
    const double inside_px = std::min(length_px, kStationSpacingPx * refined.piece_stations[side]);
    least_px = std::min(least_px, refined.piece_seen[side] * inside_px);
  }
  return least_px / width_px(camera, part, refined.pose);
}

// Whether what is seen of an outline is neither a box's nor a ball's: both ends and long sides, whose proportions no
// box shares but by chance, or a rim that bulges, and of both sides more than the touch of a rim.
bool is_telling(const Outline& outline, const RefinedPose& refined, double side_seen_px, double width_px) {
  constexpr double kMinSidePx = 8;
  constexpr double kMinSideOfWidth = 0.125;
  constexpr double kMinBulgePx = 2;
  constexpr double kMinRimSeen = 0.5;
  if (side_seen_px < std::max(kMinSidePx, kMinSideOfWidth * width_px)) return false;
  const auto is_seen = [&](std::size_t base) { return refined.piece_seen[kBase0 + base] >= kMinRimSeen; };
  if (side_seen_px > width_px && is_seen(0) && is_seen(1)) return true;
  return std::ranges::any_of(std::array{std::size_t{0}, std::size_t{1}},
                             [&](std::size_t base) { return is_seen(base) && outline.bulge_px(base) >= kMinBulgePx; });
}

// The base whose rim is most of the outline, if any.
std::optional<std::size_t> main_rim(const RefinedPose& refined, int stations) {
  for (const std::size_t base : {std::size_t{kBase0}, std::size_t{kBase1}}) {
    if (refined.piece_stations[base] > kMinRimShare * stations) return base;
  }
  return std::nullopt;
}

double sides_rms_px(const RefinedPose& refined) {
  return std::max(refined.piece_rms_px[kSide0], refined.piece_rms_px[kSide1]);
}

// How far the points of a base may lie from it, root mean square in pixels, where the other base is hidden.
double lone_base_limit_px(const CheckOptions& check, const RefinedPose& refined) {
  return std::max(check.max_lone_base_rms_px, kMaxLoneBaseOfSides * sides_rms_px(refined));
}

// The base, if any, whose points are likely an occluder's edge beside it: part of it is seen, and fits far worse than
// all else, while the other one fits as well as a lone base must.
std::optional<OutlinePiece> doubtful_base(const CheckOptions& check, const RefinedPose& refined) {
  constexpr double kMaxSeen = 0.7;
  constexpr double kMinOtherSeen = 0.5;
  constexpr double kMinRmsPx = 0.15;
  constexpr double kMinOfOthers = 3;
  for (const OutlinePiece base : {kBase0, kBase1}) {
    const OutlinePiece other_base = base == kBase0 ? kBase1 : kBase0;
    if (refined.piece_seen[base] > kMaxSeen || refined.piece_seen[other_base] < kMinOtherSeen) continue;
    if (refined.piece_rms_px[other_base] > lone_base_limit_px(check, refined)) continue;
    double squares = 0;
    double seen = 0;
    for (const OutlinePiece piece : {kSide0, kSide1, other_base}) {
      const double stations = refined.piece_seen[piece] * refined.piece_stations[piece];
      squares += stations * refined.piece_rms_px[piece] * refined.piece_rms_px[piece];
      seen += stations;
    }
    if (refined.piece_rms_px[base] > std::max(kMinRmsPx, kMinOfOthers * std::sqrt(squares / seen))) return base;
  }
  return std::nullopt;
}

// Whether the outline is hardly longer than wide, so that little but its size tells it from other round things.
bool is_blob(const CameraModel& camera, const PartModel& part, const CylinderPose& pose) {
  constexpr double kMaxLengthOfWidth = 1.5;  // from base to base
  const Eigen::Vector3d half = part.height_m / 2 * pose.axis_in_cam;
  const Eigen::Vector2d length_px =
      ideal_pixel(camera, pose.center_in_cam + half) - ideal_pixel(camera, pose.center_in_cam - half);
  return length_px.norm() < kMaxLengthOfWidth * width_px(camera, part, pose);
}

// The distance of a judging point in the scatter of its place, as pixels of one whose place is known well.
double judged_px(const CommonEdgeSigma& sigma, double distance_px, EdgeCue cue) {
  constexpr double kUsualScatterPx = 0.1;
  return distance_px / std::hypot(1.0, sigma.of(cue) / kUsualScatterPx);
}

void fail(PoseEstimate& estimate, std::string reason) {
  if (estimate.status == PoseStatus::kOk) {
    estimate.status = PoseStatus::kNone;
    estimate.reason = std::move(reason);
  }
}

}  // namespace

PoseEstimate no_pose(std::string reason) {
  PoseEstimate estimate;
  estimate.reason = std::move(reason);
  return estimate;
}

void Judge::Hearing::matched(double distance_px) {
  residuals_px.push_back(distance_px);
  ++count_;
  squares_ += distance_px * distance_px;
  block_sum_ += distance_px;
  if (++in_block_ == kBlock) {
    ++blocks_;
    block_squares_ += block_sum_ * block_sum_ / kBlock;
    in_block_ = 0;
    block_sum_ = 0;
  }
}

void Judge::Hearing::unmatched(Place place) {
  residuals_px.push_back(std::numeric_limits<double>::infinity());
  clutter += place == Place::kInside ? 1 : 0;
  beyond += place == Place::kBeyond ? 1 : 0;
  elsewhere += place == Place::kElsewhere ? 1 : 0;
}

// Variance of the blocks' means over what it would be if neighbours erred independently (survey sampling's design
// effect).
double Judge::Hearing::clumping() const {
  if (blocks_ == 0 || squares_ == 0) return kBlock;
  const double by_chance = std::sqrt(2.0 / blocks_);  // standard deviation of that ratio for independent errors
  return std::max(1.0, block_squares_ / blocks_ / (squares_ / count_) - by_chance);
}

double Judge::Hearing::scatter_px() const {
  std::vector<double> matched_px;
  std::ranges::copy_if(residuals_px, std::back_inserter(matched_px), [](double px) { return std::isfinite(px); });
  return matched_px.empty() ? std::numeric_limits<double>::infinity() : robust_sigma(matched_px);
}

Judge::Judge(const CameraModel& camera, const PartModel& part, const SolveOptions& options,
             const RegionStatistics& region, const std::vector<EdgePoint>& points, const std::vector<Chain>& chains)
    : camera_(camera),
      part_(part),
      options_(options),
      region_(region),
      points_(points),
      chains_(chains),
      judges_(along_chains(points, chains, kPointsToJudge)) {}

std::optional<Solution> Judge::refined(const CoarsePose& coarse) const {
  auto refined = refine_finely(camera_, part_, coarse.pose, points_, options_.refine);
  if (!refined) return std::nullopt;
  const auto doubtful = is_blob(camera_, part_, refined->pose) ? std::nullopt : doubtful_base(options_.check, *refined);
  if (doubtful) {
    auto without = refine_finely(camera_, part_, refined->pose, points_, options_.refine, doubtful);
    if (without) refined = std::move(without);
  }
  const auto outline = Outline::of(camera_, part_, refined->pose);
  if (!outline) return std::nullopt;

  double hits = 0;
  int stations = 0;
  for (std::size_t piece = 0; piece < kOutlinePieces; ++piece) {
    hits += refined->piece_seen[piece] * refined->piece_stations[piece];
    stations += refined->piece_stations[piece];
  }
  Solution solution;
  PoseEstimate& estimate = solution.estimate;
  estimate.status = PoseStatus::kOk;
  estimate.pose = with_fixed_sign(refined->pose);
  estimate.covariance = refined->covariance;
  estimate.rms_px = refined->rms_px;
  estimate.support = refined->support;
  estimate.seen = hits / std::max(1, stations);
  estimate.sides = outline->sides();

  const double side_seen = std::min(refined->piece_seen[kSide0], refined->piece_seen[kSide1]);
  if (estimate.seen < options_.check.min_seen) {
    fail(estimate, fmt::format("only {:.0f} % of the outline seen", 100 * estimate.seen));
  }
  const auto rim = main_rim(*refined, stations);
  solution.shows_a_rim = rim.has_value();
  solution.is_blob = is_blob(camera_, part_, refined->pose);
  const bool rim_is_seen = rim && refined->piece_seen[*rim] >= options_.check.min_rim_seen;
  if (side_seen < options_.check.min_side_seen && !rim_is_seen) {
    fail(estimate, fmt::format("only {:.0f} % of a side seen", 100 * side_seen));
  }
  if (solution.is_blob && estimate.seen < options_.check.min_blob_seen &&
      estimate.rms_px > options_.check.max_part_of_blob_rms_px) {
    fail(estimate, fmt::format("seen along its axis, {:.0f} % of the outline, and edges {:.2f} px off it",
                               100 * estimate.seen, estimate.rms_px));
  }
  const EndCheck end_check(camera_, part_, options_);
  for (const std::size_t lone_base : {std::size_t{kBase0}, std::size_t{kBase1}}) {
    const std::size_t other_base = kBase0 + kBase1 - lone_base;
    if (refined->piece_seen[other_base] >= options_.check.min_side_seen) continue;
    const double rms_px = refined->piece_rms_px[lone_base];
    if (rms_px > lone_base_limit_px(options_.check, *refined)) {
      fail(estimate, fmt::format("the only base seen fits badly ({:.2f} px)", rms_px));
    }
    if (const auto why = end_check.longer_part(*outline, other_base - kBase0, points_)) fail(estimate, *why);
    if (estimate.status != PoseStatus::kOk || sides_rms_px(*refined) < kStraightSidesPx) continue;
    const auto by_sides =
        refine_finely(camera_, part_, refined->pose, points_, options_.refine, static_cast<OutlinePiece>(lone_base));
    if (by_sides && sides_rms_px(*refined) > kMaxSidesWithLoneBase * sides_rms_px(*by_sides)) {
      fail(estimate, fmt::format("with the only base seen the sides fit worse ({:.2f} px) than without it ({:.2f} px)",
                                 sides_rms_px(*refined), sides_rms_px(*by_sides)));
    }
  }

  const auto place_of = [&](const EdgePoint& point) {
    using enum Hearing::Place;
    if (outline->within(point.position_px, kClutterMarginPx)) return kInside;
    if (outline->beyond(point.position_px, kElsewherePx)) return kElsewhere;
    return outline->beyond(point.position_px, kClutterMarginPx) ? kBeyond : kAlong;
  };
  Hearing hearing;
  std::vector<EdgePoint> unexplained;
  for (const EdgePoint& point : judges_) {
    if (const auto match = outline->match(point, options_.refine.final_gate_px)) {
      hearing.matched(judged_px(options_.refine.common_edge_sigma, match->distance_px, match->cue));
    } else {
      unexplained.push_back(point);
      hearing.unmatched(place_of(point));
    }
  }
  for (const std::size_t base : {std::size_t{0}, std::size_t{1}}) {
    if (refined->piece_seen[kBase0 + base] >= 0.5) continue;
    if (const auto why = end_check.part_of_other_length(refined->pose, base, unexplained)) fail(estimate, *why);
    if (const auto why = end_check.end_inside(*outline, base, unexplained)) fail(estimate, *why);
  }
  // Inside the image, taken to be the share of its stations that lie there.
  const double visible_area_px = outline->area_px() * stations / static_cast<double>(outline->station_count());
  const double width = width_px(camera_, part_, refined->pose);
  const double side_seen_widths = side_seen_in_widths(camera_, part_, *outline, *refined);
  solution.shows_sides = side_seen_widths > 1;
  solution.is_telling = is_telling(*outline, *refined, side_seen_widths * width, width);
  judge(solution, std::move(hearing), visible_area_px,
        colored_px([&](const EdgePoint& point) { return place_of(point) == Hearing::Place::kElsewhere; }));
  return solution;
}

std::optional<Solution> Judge::end_on(const FittedEllipse& base) const {
  const auto view = end_on_view(camera_, part_, base, points_, options_.refine.common_edge_sigma);
  if (!view) return std::nullopt;
  Solution solution;
  solution.is_end_on = true;
  solution.shows_a_rim = true;
  solution.is_blob = true;
  PoseEstimate& estimate = solution.estimate;
  estimate.status = PoseStatus::kOk;
  estimate.pose = with_fixed_sign(view->pose);
  estimate.covariance = view->covariance;
  estimate.rms_px = view->rms_px;
  estimate.support = view->support;
  estimate.seen = view->seen;
  if (estimate.seen < options_.check.min_rim_seen) {
    fail(estimate, fmt::format("seen along its axis, but only {:.0f} % of the near base", 100 * estimate.seen));
  }
  if (estimate.seen < kWholeRim && estimate.rms_px > options_.check.max_part_of_blob_rms_px) {
    fail(estimate, fmt::format("seen along its axis, {:.0f} % of the near base, and edges {:.2f} px off it",
                               100 * estimate.seen, estimate.rms_px));
  }

  const auto place_of = [&](const EdgePoint& point) {
    using enum Hearing::Place;
    const double distance_px = base.ellipse.signed_distance(point.position_px);
    if (distance_px > kClutterMarginPx) return kInside;
    if (distance_px < -kElsewherePx) return kElsewhere;
    return distance_px < -kClutterMarginPx ? kBeyond : kAlong;
  };
  Hearing hearing;
  for (const EdgePoint& point : judges_) {
    const double distance_px = base.ellipse.edge_distance(point.position_px);
    const bool matches = std::abs(distance_px) <= options_.refine.final_gate_px &&
                         base.ellipse.inward(point.position_px).dot(point.inward) > 0;
    if (matches) {
      hearing.matched(judged_px(options_.refine.common_edge_sigma, distance_px, point.cue));
    } else {
      hearing.unmatched(place_of(point));
    }
  }
  const Eigen::Vector2d half_axes_px = base.ellipse.half_axes_px();
  judge(solution, std::move(hearing), std::numbers::pi * half_axes_px.prod(),
        colored_px([&](const EdgePoint& point) { return place_of(point) == Hearing::Place::kElsewhere; }));
  return solution;
}

double Judge::colored_px(const std::function<bool(const EdgePoint&)>& is_elsewhere) const {
  auto colored = static_cast<double>(region_.m00);
  for (const Chain& chain : chains_) {
    const auto at = [&](std::size_t i) -> const EdgePoint& { return points_[static_cast<std::size_t>(chain[i])]; };
    if (!is_elsewhere(at(0)) || !is_elsewhere(at(chain.size() / 2))) continue;
    if (const auto thing = region_in_loop(points_, chain)) colored -= static_cast<double>(thing->m00);
  }
  return colored;
}

void Judge::judge(Solution& solution, Hearing hearing, double area_px, double colored_px) const {
  PoseEstimate& estimate = solution.estimate;
  const CheckOptions& check = options_.check;
  const double per_judge =
      static_cast<double>(points_.size()) / static_cast<double>(std::max<std::size_t>(1, judges_.size()));
  const double explained = estimate.support / (estimate.support + hearing.clutter * per_judge);
  const double fill = area_px > 0 ? colored_px / area_px : 0;
  // The mask's border is known to half a pixel.
  const double area_of_mask_px = area_px + std::sqrt(std::numbers::pi * area_px);
  solution.unseen = estimate.support / per_judge * (1 - estimate.seen) / std::max(estimate.seen, 0.01);
  solution.rating = estimate.seen * explained / (1 + estimate.rms_px);
  solution.clumping = hearing.clumping();
  solution.scatter_px = hearing.scatter_px();
  const double max_rms_px = solution.is_blob ? check.max_blob_rms_px * estimate.seen
                                             : check.max_rms_px * std::min(1.0, estimate.seen / kWellSeen);
  if (estimate.rms_px > max_rms_px) {
    fail(estimate, fmt::format("edges {:.2f} px off the outline", estimate.rms_px));
  }
  const bool is_clear = solution.is_telling && solution.rating > kClearlyRight;
  if (solution.is_blob && !is_clear && colored_px > check.max_blob_fill * area_of_mask_px) {
    fail(estimate,
         fmt::format("seen along its axis, but {:.0f} % more of the part's colour than that shows", 100 * (fill - 1)));
  }
  const bool is_whole = solution.is_telling && estimate.seen > kWhole;
  if (!is_whole && hearing.beyond > kMaxBeyond * hearing.matched_count()) {
    fail(estimate, fmt::format("the part's colour is seen beyond the outline, in {:.0f} % as many edges as on it",
                               100.0 * hearing.beyond / hearing.matched_count()));
  }
  solution.leaves_things = hearing.elsewhere > kMaxElsewhere * hearing.matched_count();
  if (!solution.is_telling && solution.leaves_things) {
    fail(estimate, "something else has the part's colour, and a box or a ball could look like this outline");
  }
  if (hearing.elsewhere > kMaxElsewhereAtAll * hearing.matched_count()) {
    fail(estimate, "most of what has the part's colour is something else");
  }
  solution.residuals_px = std::move(hearing.residuals_px);
  if (explained < check.min_explained) {
    fail(estimate, fmt::format("outline explains only {:.0f} % of the edges in it", 100 * explained));
  }
  if (fill < check.min_fill) {
    fail(estimate, fmt::format("only {:.0f} % of the outline has the part's colour", 100 * fill));
  }
}

double Judge::misfit(const Solution& solution, double sigma_px) const {
  double sum = kUnseenWeight * kOutlierCost * solution.unseen;
  for (const double residual_px : solution.residuals_px) {
    const double in_sigmas = residual_px / sigma_px;
    sum += std::min(kOutlierCost, in_sigmas * in_sigmas / 2);
  }
  return sum;
}

double Judge::evidence(const Solution& a, const Solution& b, double sigma_px) const {
  // So many points count as one; and what they have in common is no noise, but an error that may as well be larger.
  const double clumping = std::max(a.clumping, b.clumping);
  return (misfit(b, sigma_px) - misfit(a, sigma_px)) / (clumping * std::min(clumping, kMaxDistrust));
}

}  // namespace cylpose
