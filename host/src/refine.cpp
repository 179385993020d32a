#include <Eigen/Dense>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cylpose/pose.hpp>
#include <cylpose/refine.hpp>
#include <vector>

#include "option_check.hpp"
#include "robust_sigma.hpp"

namespace cylpose {
namespace {

using Vector5d = Eigen::Matrix<double, 5, 1>;
using Matrix5d = Eigen::Matrix<double, 5, 5>;

// Edge places are rounded to 1/256 px and never better than this: floor of the residuals' sigma.
constexpr double kMinEdgeSigmaPx = 0.02;

// Cauchy weights fall to a half at this many sigma: 95 % efficiency for Gaussian residuals.
constexpr double kCauchyScale = 2.385;

// A round that moves the outline by less than this, or than this share of the edges' sigma, ends the refinement.
constexpr double kConvergedPx = 0.002;
constexpr double kConvergedSigmas = 0.05;

// Neighbours whose errors may go together: 24 px of the outline, some blurs and the size of fine textures.
constexpr std::size_t kStationsOfBlock = 8;
// What points have in common counts in full on so many of them. Where it comes from a piece's ends (corners, things in
// front), it averages out over longer ones, but for a part that all of them share.
constexpr double kPointsInCommon = 24;
constexpr double kSharedByAll = 0.25;
// So few blocks scatter by chance, but hardly by more than this factor.
constexpr double kClumpedAbove = 2;

// Rounds with all points. One is enough where it moves the outline less than this: the distances then change linearly.
constexpr int kRoundsWithAll = 3;
constexpr double kLinearPx = 0.1;

// Moves of the pose: x y z of the centre in metres, then rotations about two unit vectors across the axis.
struct TangentBasis {
  Eigen::Vector3d first;
  Eigen::Vector3d second;

  explicit TangentBasis(const Eigen::Vector3d& axis) : first(axis.unitOrthogonal()), second(axis.cross(first)) {}
};

// How the distance of a fixed image point from the outline changes with the pose, where the outline is the image of
// this surface point.
class DistanceChange {
 public:
  DistanceChange(const CameraModel& camera, const CylinderPose& pose, const TangentBasis& basis)
      : camera_(camera), center_in_cam_(pose.center_in_cam), basis_(basis) {}

  [[nodiscard]] Vector5d at(const Eigen::Vector3d& point_in_cam, const Eigen::Vector2d& inward) const {
    const double x = camera_.fx * inward.x() / point_in_cam.z();
    const double y = camera_.fy * inward.y() / point_in_cam.z();
    const Eigen::Vector3d by_point(-x, -y, (x * point_in_cam.x() + y * point_in_cam.y()) / point_in_cam.z());
    const Eigen::Vector3d by_turn = (point_in_cam - center_in_cam_).cross(by_point);
    Vector5d change;
    change << by_point, by_turn.dot(basis_.first), by_turn.dot(basis_.second);
    return change;
  }

 private:
  const CameraModel& camera_;
  Eigen::Vector3d center_in_cam_;
  const TangentBasis& basis_;
};

// One Gauss-Newton step's least squares problem: `normal` moves = -`gradient`.
struct RoundProblem {
  Matrix5d normal = Matrix5d::Zero();
  std::array<Matrix5d, kOutlinePieces> of_piece{};  // each piece's share of it
  Vector5d gradient = Vector5d::Zero();
};

// The points of a side need no rows of their own: a straight line moves as a whole, so that a point's distance changes
// in proportion to its share of the way from one end to the other, and sums of weights, shares and distances suffice.
struct SideSums {
  double weight = 0;
  double share = 0;
  double share_squared = 0;
  double distance = 0;
  double distance_share = 0;

  void add(double w, const OutlineMatch& match) {
    const double w_share = w * match.share;
    weight += w;
    share += w_share;
    share_squared += w_share * match.share;
    distance += w * match.distance_px;
    distance_share += w_share * match.distance_px;
  }

  // `from`, `to`: change of the distance at the two ends.
  void add_to(RoundProblem& problem, OutlinePiece side, const Vector5d& from, const Vector5d& to) const {
    const Vector5d along = to - from;
    const Matrix5d mixed = from * along.transpose();
    problem.of_piece[side] = weight * from * from.transpose() + share * (mixed + mixed.transpose()) +
                             share_squared * along * along.transpose();
    problem.gradient += distance * from + distance_share * along;
  }
};

class Refinement {
 public:
  Refinement(const CameraModel& camera, const PartModel& part, const CylinderPose& start, const RefineOptions& options,
             std::optional<OutlinePiece> without = std::nullopt)
      : camera_(camera),
        part_(part),
        options_(options),
        start_(start),
        without_(without),
        pose_(start),
        basis_(start.axis_in_cam) {}

  // Matches the points with the outline of the pose reached so far. False when there is too little to go on.
  bool match(std::span<const EdgePoint> points, double gate_px) {
    outline_ = Outline::of(camera_, part_, pose_);
    if (!outline_) return false;
    matched_.clear();
    matched_.reserve(points.size());
    for (const EdgePoint& point : points) {
      const auto match = outline_->match(point, gate_px);
      if (match && match->piece != without_) matched_.push_back(*match);
    }
    if (static_cast<int>(matched_.size()) < kMinSupport) return false;
    sigma_px_ = edge_sigma();
    linearise();
    return true;
  }

  // Moves the pose to where the matched points' distances, taken as linear, are least. None when that leads nowhere,
  // else how far the outline moved in pixels (root mean square over the matched points).
  std::optional<double> step() {
    problem_ = weighted();
    const Vector5d moves = -problem_.normal.ldlt().solve(problem_.gradient);
    move(moves);
    if (!pose_.center_in_cam.allFinite() || !pose_.axis_in_cam.allFinite()) return std::nullopt;
    last_moves_ = moves;
    return std::sqrt(moves.dot(problem_.normal * moves) / static_cast<double>(matched_.size()));
  }

  // The matched points' distances from the outline after the last step.
  void follow_linearly() {
    std::size_t row = 0;
    std::array<double, 2> from{};
    std::array<double, 2> along{};
    for (const std::size_t side : {kSide0, kSide1}) {
      from[side] = at_side_ends_[side][0].dot(last_moves_);
      along[side] = at_side_ends_[side][1].dot(last_moves_) - from[side];
    }
    for (OutlineMatch& match : matched_) {
      match.distance_px += is_side(match.piece) ? from[match.piece] + match.share * along[match.piece]
                                                : on_bases_[row++].dot(last_moves_);
    }
    sigma_px_ = edge_sigma();
  }

  [[nodiscard]] bool converged(double moved_px) const {
    return moved_px < std::max(kConvergedPx, kConvergedSigmas * sigma_px_);
  }

  [[nodiscard]] CoarsePose coarse_result() const {
    double squares = 0;
    for (const OutlineMatch& match : matched_) squares += match.distance_px * match.distance_px;
    const auto support = static_cast<int>(matched_.size());
    return {pose_, support, std::sqrt(squares / support)};
  }

  // What the last match saw; the moves since then were too small to see.
  [[nodiscard]] RefinedPose result() const {
    std::vector<std::size_t> stations;
    stations.reserve(matched_.size());
    for (const OutlineMatch& match : matched_) stations.push_back(outline_->station_of(match));
    RefinedPose refined;
    refined.pose = pose_;
    refined.covariance = covariance(stations);
    refined.support = static_cast<int>(matched_.size());
    measure_residuals(refined);
    count_seen(refined, stations);
    return refined;
  }

 private:
  static bool is_side(OutlinePiece piece) { return piece == kSide0 || piece == kSide1; }

  double edge_sigma() {
    distances_.clear();
    for (const OutlineMatch& match : matched_) distances_.push_back(match.distance_px);
    return std::max(kMinEdgeSigmaPx, robust_sigma(distances_));
  }

  // A point's share in the scatter of its place, which is the points' scatter and what its cue may err; by its distance
  // in that, Cauchy's.
  [[nodiscard]] auto weight_of_match() const {
    return [this, per_sigma = 1 / sigma_px_](const OutlineMatch& match) {
      const double common = options_.common_edge_sigma.of(match.cue) * per_sigma;
      const double scaled = match.distance_px * per_sigma / kCauchyScale;
      return 1 / (1 + common * common + scaled * scaled);
    };
  }

  // How the matched points' distances change with the pose: of sides at their ends, of bases point by point.
  void linearise() {
    basis_ = TangentBasis(pose_.axis_in_cam);
    const DistanceChange change(camera_, pose_, basis_);
    for (const OutlinePiece side : {kSide0, kSide1}) {
      const Eigen::Vector2d& inward = outline_->sides()[side].normal;
      for (const std::size_t end : {0U, 1U}) {
        at_side_ends_[side][end] = change.at(outline_->end_of_side(side, end), inward);
      }
    }
    on_bases_.clear();
    for (const OutlineMatch& match : matched_) {
      if (!is_side(match.piece)) on_bases_.push_back(change.at(outline_->point_on_base(match), match.inward));
    }
  }

  [[nodiscard]] RoundProblem weighted() const {
    const auto weight_of = weight_of_match();
    RoundProblem problem;
    problem.of_piece.fill(Matrix5d::Zero());
    std::array<SideSums, 2> sides;
    std::size_t row = 0;
    for (const OutlineMatch& match : matched_) {
      const double weight = weight_of(match);
      if (is_side(match.piece)) {
        sides[match.piece].add(weight, match);
      } else {
        const Vector5d& by_pose = on_bases_[row++];
        const Vector5d weighted = weight * by_pose;
        problem.of_piece[match.piece] += weighted * by_pose.transpose();
        problem.gradient += match.distance_px * weighted;
      }
    }
    for (const OutlinePiece side : {kSide0, kSide1}) {
      sides[side].add_to(problem, side, at_side_ends_[side][0], at_side_ends_[side][1]);
    }
    for (const Matrix5d& piece : problem.of_piece) problem.normal += piece;
    add_prior(problem);
    return problem;
  }

  void add_prior(RoundProblem& problem) const {
    const double prior = sigma_px_ / (part_.height_m / 2);
    const Eigen::Vector3d& axis = pose_.axis_in_cam;
    problem.normal.topLeftCorner<3, 3>() += prior * prior * axis * axis.transpose();
    problem.gradient.head<3>() += prior * prior * axis.dot(pose_.center_in_cam - start_.center_in_cam) * axis;
  }

  void move(const Vector5d& moves) {
    const Eigen::Vector3d rotation = moves[3] * basis_.first + moves[4] * basis_.second;
    pose_.center_in_cam += moves.head<3>();
    pose_.axis_in_cam = (pose_.axis_in_cam + rotation.cross(pose_.axis_in_cam)).normalized();
  }

  [[nodiscard]] Eigen::Matrix<double, 6, 6> covariance(std::span<const std::size_t> stations) const {
    const Matrix5d inverse = problem_.normal.ldlt().solve(Matrix5d::Identity());
    const std::array<PieceScatter, kOutlinePieces> scatters = scatter_of_pieces(stations);
    // The prior's share, and of every piece what its points' scatter makes of its share.
    Matrix5d scatter = sigma_px_ * sigma_px_ * problem_.normal;
    for (std::size_t piece = 0; piece < kOutlinePieces; ++piece) {
      scatter += (scatters[piece].variance - sigma_px_ * sigma_px_) * problem_.of_piece[piece];
    }
    Matrix5d covariance = inverse * scatter * inverse;
    const auto add = [&](const Vector5d& pull) {
      const Vector5d moved = inverse * pull;
      covariance += moved * moved.transpose();
    };
    const Pulls pulls = pulls_of_common_errors();
    for (std::size_t piece = 0; piece < kOutlinePieces; ++piece) {
      const double clumped_px = options_.common_edge_share * std::sqrt(scatters[piece].clumped);
      for (const PullOfHalf& half : pulls.of_halves[piece]) {
        add(std::hypot(kSharedByAll, kPointsInCommon / std::max(1, half.points)) * half.by_cues);
        add(clumped_px * half.per_px);
      }
    }
    add(pulls.by_clipping);
    Eigen::Matrix<double, 6, 5> to_full = Eigen::Matrix<double, 6, 5>::Zero();
    to_full.topLeftCorner<3, 3>().setIdentity();
    to_full.block<3, 1>(3, 3) = basis_.first;
    to_full.block<3, 1>(3, 4) = basis_.second;
    Eigen::Matrix<double, 6, 6> full = to_full * covariance * to_full.transpose();
    full.bottomRightCorner<3, 3>() += kUnobservableRoll * pose_.axis_in_cam * pose_.axis_in_cam.transpose();
    return full;
  }

  // How a common shift of all points of half a piece pulls the pose.
  struct PullOfHalf {
    int points = 0;
    Vector5d per_px = Vector5d::Zero();
    Vector5d by_cues = Vector5d::Zero();  // where each point is shifted by the common sigma of its cue
  };
  struct Pulls {
    std::array<std::array<PullOfHalf, 2>, kOutlinePieces> of_halves;
    Vector5d by_clipping = Vector5d::Zero();  // of all points before an overexposed background
  };

  [[nodiscard]] Pulls pulls_of_common_errors() const {
    Pulls pulls;
    const auto weight_of = weight_of_match();
    std::size_t row = 0;
    for (const OutlineMatch& match : matched_) {
      const double weight = weight_of(match);
      Vector5d by_pose;
      if (is_side(match.piece)) {
        const auto& [from, to] = at_side_ends_[match.piece];
        by_pose = from + match.share * (to - from);
      } else {
        by_pose = on_bases_[row++];
      }
      PullOfHalf& half = pulls.of_halves[match.piece][outline_->share_of(match) < 0.5 ? 0 : 1];
      ++half.points;
      half.per_px += weight * by_pose;
      const Vector5d by_cue = weight * options_.common_edge_sigma.of(match.cue) * by_pose;
      (match.cue == EdgeCue::kClipped ? pulls.by_clipping : half.by_cues) += by_cue;
    }
    return pulls;
  }

  struct PieceScatter {
    double variance;  // of a point, as if the points erred independently
    double clumped;   // the part of it that is clearly more than independent errors make
  };

  // Where points do not err independently (texture behind the part pulls neighbours alike), sums over blocks of
  // neighbours scatter more than sums of independent errors would, and by that much the variance is larger
  // (cluster-robust variance: Liang and Zeger 1986). The five parameters take their share of the scatter away.
  [[nodiscard]] std::array<PieceScatter, kOutlinePieces> scatter_of_pieces(
      std::span<const std::size_t> stations) const {
    const std::size_t blocks = outline_->station_count() / kStationsOfBlock + 1;
    std::vector<double> sums(kOutlinePieces * blocks);  // piece after piece
    std::array<double, kOutlinePieces> weights{};
    std::array<double, kOutlinePieces> squares_of_weights{};
    std::array<double, kOutlinePieces> squares_of_points{};
    const auto weight_of = weight_of_match();
    for (std::size_t i = 0; i < matched_.size(); ++i) {
      const OutlineMatch& match = matched_[i];
      const double weight = weight_of(match);
      const double weighted = weight * match.distance_px;
      sums[match.piece * blocks + stations[i] / kStationsOfBlock] += weighted;
      weights[match.piece] += weight;
      squares_of_weights[match.piece] += weight * weight;
      squares_of_points[match.piece] += weighted * weighted;
    }
    const auto used_blocks = static_cast<double>(std::ranges::count_if(sums, [](double sum) { return sum != 0; }));
    const double for_parameters = used_blocks > 10 ? used_blocks / (used_blocks - 5) : 2;
    std::array<PieceScatter, kOutlinePieces> scatters{};
    for (std::size_t piece = 0; piece < kOutlinePieces; ++piece) {
      double squares = 0;
      for (std::size_t block = 0; block < blocks; ++block) {
        squares += sums[piece * blocks + block] * sums[piece * blocks + block];
      }
      if (weights[piece] == 0) continue;  // no points
      squares *= for_parameters;
      scatters[piece] = {std::max(sigma_px_ * sigma_px_, squares / weights[piece]),
                         std::max(0.0, squares - kClumpedAbove * squares_of_points[piece]) / squares_of_weights[piece]};
    }
    return scatters;
  }

  void measure_residuals(RefinedPose& refined) const {
    std::array<double, kOutlinePieces> squares{};
    std::array<int, kOutlinePieces> counts{};
    for (const OutlineMatch& match : matched_) {
      squares[match.piece] += match.distance_px * match.distance_px;
      ++counts[match.piece];
    }
    double all = 0;
    for (std::size_t piece = 0; piece < kOutlinePieces; ++piece) {
      refined.piece_rms_px[piece] = counts[piece] > 0 ? std::sqrt(squares[piece] / counts[piece]) : 0;
      all += squares[piece];
    }
    refined.rms_px = std::sqrt(all / refined.support);
  }

  void count_seen(RefinedPose& refined, std::span<const std::size_t> matched_stations) const {
    const auto stations = outline_->stations();
    std::vector<bool> hit(stations.size(), false);
    for (const std::size_t station : matched_stations) hit[station] = true;
    std::array<int, kOutlinePieces> hits{};
    refined.piece_stations = {};
    for (std::size_t i = 0; i < stations.size(); ++i) {
      const Eigen::Vector2d& position = stations[i].position_px;
      if (position.x() < 1 || position.y() < 1 || position.x() > camera_.width - 2 ||
          position.y() > camera_.height - 2) {
        continue;
      }
      const OutlinePiece piece = stations[i].piece;
      ++refined.piece_stations[piece];
      if (hit[i]) ++hits[piece];
    }
    for (std::size_t piece = 0; piece < kOutlinePieces; ++piece) {
      refined.piece_seen[piece] =
          refined.piece_stations[piece] > 0 ? static_cast<double>(hits[piece]) / refined.piece_stations[piece] : 0;
    }
  }

  const CameraModel& camera_;
  const PartModel& part_;
  const RefineOptions& options_;
  CylinderPose start_;
  std::optional<OutlinePiece> without_;
  CylinderPose pose_;
  std::optional<Outline> outline_;  // of the pose that the last match started from
  std::vector<OutlineMatch> matched_;
  TangentBasis basis_;                                   // at that pose, as are
  std::array<std::array<Vector5d, 2>, 2> at_side_ends_;  // the changes of the sides' distances and
  std::vector<Vector5d> on_bases_;                       // those of the points on bases, in their order
  RoundProblem problem_;
  Vector5d last_moves_ = Vector5d::Zero();
  std::vector<double> distances_;
  double sigma_px_ = 0;
};

}  // namespace

bool RefineOptions::is_valid(std::string* why) const {
  return require_positive(first_gate_px, "refine.first_gate_px", why) &&
         require_positive(final_gate_px, "refine.final_gate_px", why) &&
         require_at_least(rounds, 1, "refine.rounds", why) &&
         require_positive(common_edge_sigma.by_share_px, "refine.common_edge_sigma.by_share_px", why) &&
         require_positive(common_edge_sigma.by_limb_px, "refine.common_edge_sigma.by_limb_px", why) &&
         require_positive(common_edge_sigma.by_slope_px, "refine.common_edge_sigma.by_slope_px", why) &&
         require_positive(common_edge_sigma.by_none_px, "refine.common_edge_sigma.by_none_px", why) &&
         require_positive(common_edge_sigma.by_clipped_px, "refine.common_edge_sigma.by_clipped_px", why) &&
         require_positive(common_edge_share, "refine.common_edge_share", why);
}

std::optional<CoarsePose> refine_coarsely(const CameraModel& camera, const PartModel& part, const CylinderPose& start,
                                          std::span<const EdgePoint> points, const RefineOptions& options) {
  Refinement refinement(camera, part, start, options);
  double gate_px = options.first_gate_px;
  for (int round = 0; round < options.rounds; ++round) {
    if (!refinement.match(points, gate_px)) return std::nullopt;
    const auto moved_px = refinement.step();
    if (!moved_px) return std::nullopt;
    if (gate_px <= options.final_gate_px && refinement.converged(*moved_px)) break;
    gate_px = std::max(options.final_gate_px, gate_px / 2);
  }
  return refinement.coarse_result();
}

std::optional<RefinedPose> refine_finely(const CameraModel& camera, const PartModel& part, const CylinderPose& start,
                                         std::span<const EdgePoint> points, const RefineOptions& options,
                                         std::optional<OutlinePiece> without) {
  Refinement refinement(camera, part, start, options, without);
  for (int round = 0; round < kRoundsWithAll; ++round) {
    if (!refinement.match(points, options.final_gate_px)) return std::nullopt;
    const auto moved_px = refinement.step();
    if (!moved_px) return std::nullopt;
    refinement.follow_linearly();
    if (*moved_px < kLinearPx) break;
  }
  if (!refinement.step()) return std::nullopt;
  refinement.follow_linearly();
  return refinement.result();
}

std::optional<RefinedPose> refine(const CameraModel& camera, const PartModel& part, const CylinderPose& start,
                                  std::span<const EdgePoint> points, const RefineOptions& options) {
  const auto coarse = refine_coarsely(camera, part, start, thinned(points, kPointsToComeNear), options);
  return coarse ? refine_finely(camera, part, coarse->pose, points, options) : std::nullopt;
}

}  // namespace cylpose
