#include "contest.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cylpose/contour.hpp>
#include <cylpose/outline.hpp>
#include <cylpose/refine.hpp>
#include <limits>
#include <numbers>
#include <utility>

namespace cylpose {
namespace {

// Hypotheses that are refined, of those entered together, at the place of the one that explains most and elsewhere; the
// others are only compared by what they explain.
constexpr std::size_t kMaxRefined = 3;
constexpr std::size_t kMaxPlaces = 2;
// Edge points by which hypotheses are compared.
constexpr std::size_t kPointsToCompare = 200;
// Hypotheses so near to each other lead to the same pose; poses so near to each other are the same.
constexpr double kSameStartPx = 1;
constexpr double kSameEndPx = 0.05;
// A coarse pose supported by fewer points than this share of the best one's at its place is not refined.
constexpr double kWorthRefining = 0.8;
// A solution rated higher leaves nothing for another hypothesis to explain.
constexpr double kClearlyRight = 0.7;
// Edges of the part scatter at least this much.
constexpr double kMinSigmaPx = 0.05;
// Poses farther apart than this are different answers; nearer ones are one answer with a larger covariance.
constexpr double kOtherAxis = 10 * std::numbers::pi / 180;
constexpr double kOtherCenter = 0.25;  // of the height

// Whether two poses show the same outline to within a small part of a pixel: the ends of the axis, and the widths
// there.
bool look_alike(const CameraModel& camera, const PartModel& part, const CylinderPose& a, const CylinderPose& b,
                double tolerance_px) {
  const double turn = a.axis_in_cam.dot(b.axis_in_cam) < 0 ? -1 : 1;
  for (const double end : {-0.5, 0.5}) {
    const Eigen::Vector3d end_a = a.center_in_cam + end * part.height_m * a.axis_in_cam;
    const Eigen::Vector3d end_b = b.center_in_cam + turn * end * part.height_m * b.axis_in_cam;
    const double width_a = 2 * part.radius_m * camera.fx / end_a.z();
    const double width_b = 2 * part.radius_m * camera.fx / end_b.z();
    if (!((ideal_pixel(camera, end_a) - ideal_pixel(camera, end_b)).norm() < tolerance_px)) return false;
    if (!(std::abs(width_a - width_b) < tolerance_px)) return false;
  }
  return true;
}

// Whether the outlines, or most of them, lie beside each other.
bool are_apart(const CameraModel& camera, const PartModel& part, const CylinderPose& a, const CylinderPose& b) {
  const auto radius_px = [&](const CylinderPose& pose) {
    const Eigen::Vector3d half = part.height_m / 2 * pose.axis_in_cam;
    const Eigen::Vector2d half_px =
        ideal_pixel(camera, pose.center_in_cam + half) - ideal_pixel(camera, pose.center_in_cam);
    return std::max(half_px.norm(), part.radius_m * camera.fx / pose.center_in_cam.z());
  };
  return (ideal_pixel(camera, a.center_in_cam) - ideal_pixel(camera, b.center_in_cam)).norm() >
         radius_px(a) + radius_px(b);
}

// Of the two widths of the outline at its ends: what differs between a pose and its mirror image is twice this.
double perspective_px(const CameraModel& camera, const PartModel& part, const CylinderPose& pose) {
  const double half = part.height_m / 2 * pose.axis_in_cam.z();
  const double z = pose.center_in_cam.z();
  return std::abs(2 * part.radius_m * camera.fx * (1 / (z - half) - 1 / (z + half)));
}

// Whether the mirror image's residuals would stand out: they are about a fourth of what differs, where both ends are
// seen.
bool perspective_tells(const CameraModel& camera, const PartModel& part, const PoseEstimate& estimate) {
  constexpr double kTellingPx = 0.5;
  constexpr double kTellingSigmas = 10;
  constexpr double kMostSeen = 0.75;
  return estimate.seen > kMostSeen &&
         perspective_px(camera, part, estimate.pose) > kTellingPx + kTellingSigmas * estimate.rms_px;
}

CylinderPose mirror_image(const CylinderPose& pose) {
  const Eigen::Vector3d sight = pose.center_in_cam.normalized();
  return {pose.center_in_cam, pose.axis_in_cam - 2 * pose.axis_in_cam.dot(sight) * sight};
}

// Centre, then rotation that turns one axis into the other, whatever their signs.
Eigen::Matrix<double, 6, 1> difference(const CylinderPose& from, const CylinderPose& to) {
  const double turn = from.axis_in_cam.dot(to.axis_in_cam) < 0 ? -1 : 1;
  const Eigen::Vector3d sine = turn * from.axis_in_cam.cross(to.axis_in_cam);
  Eigen::Matrix<double, 6, 1> change;
  change << to.center_in_cam - from.center_in_cam,
      sine.normalized() * std::atan2(sine.norm(), turn * from.axis_in_cam.dot(to.axis_in_cam));
  return change;
}

bool is_near(const Eigen::Matrix<double, 6, 1>& change, double max_center, double max_angle) {
  return change.head<3>().norm() <= max_center && change.tail<3>().norm() <= max_angle;
}

// Moves the pose, and turns the covariance with its axis: the roll, which nothing shows, stays a roll.
void move(PoseEstimate& estimate, const Eigen::Matrix<double, 6, 1>& change) {
  const Eigen::Vector3d rotation = change.tail<3>();
  const Eigen::Matrix3d turn(Eigen::AngleAxisd(rotation.norm(), rotation.stableNormalized()));
  estimate.pose.center_in_cam += change.head<3>();
  estimate.pose.axis_in_cam = turn * estimate.pose.axis_in_cam;
  estimate.covariance.rightCols<3>() *= turn.transpose();
  estimate.covariance.bottomRows<3>().applyOnTheLeft(turn);
}

// The estimate, or none where its own covariance says that it is worth nothing.
PoseEstimate precise_enough(const CheckOptions& check, PoseEstimate estimate) {
  const double axis_sigma_deg = estimate.sigma_axis_rad() * 180 / std::numbers::pi;
  if (!(axis_sigma_deg <= check.max_axis_sigma_deg)) {
    return no_pose(fmt::format("the axis is known to {:.0f} deg only", axis_sigma_deg));
  }
  const Eigen::Vector3d& axis = estimate.pose.axis_in_cam;
  const Eigen::Vector3d& center = estimate.pose.center_in_cam;
  const Eigen::Vector3d across = center - axis.dot(center) * axis;  // from the pinhole to the axis line
  const double line_sigma_m = std::sqrt(across.dot(estimate.covariance.topLeftCorner<3, 3>() * across)) / across.norm();
  if (line_sigma_m > check.max_line_sigma * center.norm()) {
    return no_pose(fmt::format("the distance of the axis is known to {:.0f} mm only", 1000 * line_sigma_m));
  }
  return estimate;
}

bool is_ok(const Solution& solution) {
  return solution.estimate.status == PoseStatus::kOk;
}

}  // namespace

Contest::Contest(const CameraModel& camera, const PartModel& part, const SolveOptions& options,
                 const RegionStatistics& region, const std::vector<EdgePoint>& points, const std::vector<Chain>& chains)
    : camera_(camera),
      part_(part),
      options_(options),
      judge_(camera, part, options, region, points, chains),
      to_compare_(thinned(points, kPointsToCompare)),
      to_come_near_(thinned(points, kPointsToComeNear)) {}

std::optional<Hypothesis> Contest::hypothesis(const CylinderPose& pose) const {
  const auto outline = Outline::of(camera_, part_, pose);
  if (!outline || to_compare_.empty()) return std::nullopt;
  const auto explained = std::count_if(to_compare_.begin(), to_compare_.end(), [&](const EdgePoint& point) {
    return outline->match(point, options_.refine.first_gate_px);
  });
  return Hypothesis{pose, static_cast<double>(explained) / static_cast<double>(to_compare_.size())};
}

void Contest::enter(std::vector<Hypothesis> hypotheses) {
  std::stable_sort(hypotheses.begin(), hypotheses.end(),
                   [](const Hypothesis& a, const Hypothesis& b) { return a.explained > b.explained; });
  std::vector<CylinderPose> tried;
  std::vector<CoarsePose> coarse;
  std::size_t at_first_place = 0;
  for (const Hypothesis& hypothesis : hypotheses) {
    if (tried.size() == kMaxPlaces * kMaxRefined) break;
    const bool at_first = !are_apart(camera_, part_, hypotheses.front().pose, hypothesis.pose);
    if (at_first && ++at_first_place > kMaxRefined) continue;
    const bool known = std::any_of(tried.begin(), tried.end(), [&](const CylinderPose& other) {
      return look_alike(camera_, part_, hypothesis.pose, other, kSameStartPx);
    });
    if (known) continue;
    tried.push_back(hypothesis.pose);
    const auto reached = refine_coarsely(camera_, part_, hypothesis.pose, to_come_near_, options_.refine);
    if (reached) coarse.push_back(*reached);
  }
  std::stable_sort(coarse.begin(), coarse.end(),
                   [](const CoarsePose& a, const CoarsePose& b) { return a.support > b.support; });
  for (const CoarsePose& pose : coarse) {
    const auto best = std::ranges::find_if(
        coarse, [&](const CoarsePose& other) { return !are_apart(camera_, part_, other.pose, pose.pose); });
    if (pose.support < kWorthRefining * best->support || is_hopeless(pose)) continue;
    finish(pose);
    if (is_decided()) return;
  }
}

void Contest::enter(std::span<const CylinderPose> poses) {
  std::vector<Hypothesis> hypotheses;
  for (const CylinderPose& pose : poses) {
    if (const auto made = hypothesis(pose)) hypotheses.push_back(*made);
  }
  enter(std::move(hypotheses));
}

void Contest::enter_end_on(std::span<const FittedEllipse> ellipses) {
  for (const FittedEllipse& ellipse : ellipses) {
    if (auto solution = judge_.end_on(ellipse)) solutions_.push_back(std::move(*solution));
  }
}

void Contest::enter_mirror_image() {
  const Solution* first = leader();
  if (first == nullptr || first->is_end_on) return;
  const PoseEstimate& estimate = first->estimate;
  if (perspective_tells(camera_, part_, estimate)) return;
  const auto coarse = refine_coarsely(camera_, part_, mirror_image(estimate.pose), to_come_near_, options_.refine);
  if (coarse && !is_hopeless(*coarse)) finish(*coarse);
}

bool Contest::is_one_answer(const Solution& a, const Solution& b) const {
  return is_near(difference(a.estimate.pose, b.estimate.pose), kOtherCenter * part_.height_m, kOtherAxis);
}

// From the pose midway neither is another answer, nor farther away than the limit of a pose's own doubt.
bool Contest::may_lie_midway(const Solution& a, const Solution& b) const {
  if (a.is_end_on || b.is_end_on) return false;
  const double doubted = 2 * options_.check.max_line_sigma * a.estimate.pose.center_in_cam.norm();
  return is_near(difference(a.estimate.pose, b.estimate.pose), std::max(kOtherCenter * part_.height_m, doubted),
                 2 * kOtherAxis);
}

// Whether a pose refined before, at the same place, explains the points so much better that this one can raise no
// doubt.
bool Contest::is_hopeless(const CoarsePose& coarse) const {
  const auto rival = std::ranges::max_element(finished_, {}, [&](const CoarsePose& other) {
    return are_apart(camera_, part_, other.pose, coarse.pose) ? 0 : other.support;
  });
  if (rival == finished_.end() || are_apart(camera_, part_, rival->pose, coarse.pose)) return false;
  const double sigma_px = std::max(kMinSigmaPx, std::min(rival->rms_px, coarse.rms_px));
  const auto misfit = [&](const CoarsePose& pose) {
    const double in_sigmas = pose.rms_px / sigma_px;
    return Judge::kOutlierCost * (static_cast<double>(to_come_near_.size()) - pose.support) +
           pose.support * std::min(Judge::kOutlierCost, in_sigmas * in_sigmas / 2);
  };
  const double per_judge = static_cast<double>(Judge::kPointsToJudge) / static_cast<double>(kPointsToComeNear);
  return per_judge * (misfit(coarse) - misfit(*rival)) > Judge::kMostDistrust * options_.check.min_evidence;
}

void Contest::finish(const CoarsePose& coarse) {
  const bool known = std::any_of(finished_.begin(), finished_.end(), [&](const CoarsePose& other) {
    return look_alike(camera_, part_, coarse.pose, other.pose, kSameEndPx);
  });
  if (known) return;
  finished_.push_back(coarse);
  if (auto solution = judge_.refined(coarse)) solutions_.push_back(std::move(*solution));
}

// How far edges of the part lie from its outline: as far as the best fit with many of them says.
double Contest::edge_sigma_px() const {
  int most = 0;
  for (const Solution& solution : solutions_) most = std::max(most, solution.estimate.support);
  double sigma_px = std::numeric_limits<double>::infinity();
  for (const Solution& solution : solutions_) {
    if (2 * solution.estimate.support > most) sigma_px = std::min(sigma_px, solution.scatter_px);
  }
  return std::max(kMinSigmaPx, sigma_px);
}

const Solution* Contest::leader() const {
  const double sigma_px = edge_sigma_px();
  const auto found = std::min_element(solutions_.begin(), solutions_.end(), [&](const Solution& a, const Solution& b) {
    return judge_.misfit(a, sigma_px) < judge_.misfit(b, sigma_px);
  });
  return found == solutions_.end() ? nullptr : &*found;
}

bool Contest::shows_sides() const {
  const Solution* first = leader();
  return first != nullptr && is_ok(*first) && first->shows_sides && !first->leaves_things;
}

bool Contest::is_decided() const {
  const Solution* first = leader();
  // A rim alone may tilt either way.
  return first != nullptr && is_ok(*first) && !first->shows_a_rim && !first->leaves_things &&
         first->rating > kClearlyRight;
}

// The leader; but of what explains the edges about as well, the view of a base alone, whose covariance covers all that
// could hide behind it, and otherwise a pose that passes the self-check before one that does not, unless that is the
// same answer and fits better.
const Solution* Contest::preferred() const {
  const Solution* first = leader();
  const double sigma_px = edge_sigma_px();
  const auto misfit = [&](const Solution& solution) { return judge_.misfit(solution, sigma_px); };
  const auto is_refuted = [&](const Solution& solution) {
    return std::ranges::any_of(solutions_, [&](const Solution& other) {
      return !is_ok(other) && misfit(other) < misfit(solution) && is_one_answer(other, solution);
    });
  };
  const Solution* chosen = first;
  for (const Solution& solution : solutions_) {
    if (!is_ok(solution) || judge_.evidence(*first, solution, sigma_px) > options_.check.min_evidence) continue;
    if (is_refuted(solution)) continue;
    const bool better = !is_ok(*chosen) || (solution.is_end_on && !chosen->is_end_on) ||
                        (solution.is_end_on == chosen->is_end_on && misfit(solution) < misfit(*chosen));
    if (better) chosen = &solution;
  }
  return chosen;
}

// Where a base alone explains the edges as well as a pose beside it, but too little of it is seen to be believed, the
// rest of that pose's outline is no more than what a few edges happen to fit.
std::optional<std::string> Contest::base_alone_instead_of(const Solution& chosen, double sigma_px) const {
  if (chosen.is_end_on) return std::nullopt;
  const auto base = std::ranges::find_if(solutions_, [&](const Solution& other) {
    return other.is_end_on && !is_ok(other) && is_one_answer(chosen, other) &&
           judge_.evidence(chosen, other, sigma_px) < options_.check.min_evidence;
  });
  return base == solutions_.end() ? std::nullopt : std::optional(base->estimate.reason);
}

void Contest::dismiss_other_things() {
  std::vector<CylinderPose> telling;
  for (const Solution& solution : solutions_) {
    if (is_ok(solution) && solution.is_telling) telling.push_back(solution.estimate.pose);
  }
  std::erase_if(solutions_, [&](const Solution& solution) {
    return !solution.is_telling && std::ranges::any_of(telling, [&](const CylinderPose& pose) {
      return are_apart(camera_, part_, pose, solution.estimate.pose);
    });
  });
}

PoseEstimate Contest::verdict() const {
  if (solutions_.empty()) return no_pose("no pose explains the edges");
  const Solution& chosen = *preferred();
  const double sigma_px = edge_sigma_px();
  if (!is_ok(chosen)) return no_pose(chosen.estimate.reason);
  if (const auto why = base_alone_instead_of(chosen, sigma_px)) return no_pose(*why);
  PoseEstimate estimate = chosen.estimate;
  Eigen::Matrix<double, 6, 1> widest = Eigen::Matrix<double, 6, 1>::Zero();  // of undecided differences
  for (const Solution& other : solutions_) {
    if (&other == &chosen) continue;
    const Eigen::Matrix<double, 6, 1> change = difference(estimate.pose, other.estimate.pose);
    const double evidence = judge_.evidence(chosen, other, sigma_px);
    if (is_one_answer(chosen, other)) {
      if (is_ok(other) && !chosen.is_end_on) {
        estimate.covariance += change * change.transpose() / (1 + std::exp(std::min(evidence, 100.0)));
      }
    } else if (evidence < options_.check.min_evidence) {
      if (!may_lie_midway(chosen, other)) {
        return no_pose(fmt::format(
            "two poses explain the outline equally, their axes {:.0f} deg and their centres {:.0f} mm apart",
            change.tail<3>().norm() * 180 / std::numbers::pi, 1000 * change.head<3>().norm()));
      }
      if (change.tail<3>().norm() > widest.tail<3>().norm()) widest = change;
    }
  }
  const Eigen::Matrix<double, 6, 1> half = widest / 2;
  move(estimate, half);
  estimate.covariance += half * half.transpose();
  estimate.pose = with_fixed_sign(estimate.pose);
  return precise_enough(options_.check, std::move(estimate));
}

}  // namespace cylpose
