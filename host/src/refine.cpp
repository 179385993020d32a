#include <Eigen/Dense>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cylpose/pose.hpp>
#include <cylpose/refine.hpp>
#include <vector>

#include "option_check.hpp"

namespace cylpose {
namespace {

using Vector5d = Eigen::Matrix<double, 5, 1>;
using Matrix5d = Eigen::Matrix<double, 5, 5>;

// Edge places are rounded to 1/256 px and never better than this: floor of the residuals' sigma.
constexpr double kMinEdgeSigmaPx = 0.02;

// A round that moves the outline by less than this ends the refinement.
constexpr double kConvergedPx = 0.002;

// The first rounds only have to come near: they need no more points than this.
constexpr std::size_t kPointsToComeNear = 250;
// So near to the end the second round with all points moves hardly anything, and the third nothing.
constexpr int kRoundsWithAll = 3;

struct MatchedPoint {
  OutlineMatch match;
  double weight;  // root of the Cauchy weight
};

// Moves of the pose: x y z of the centre in metres, then rotations about two unit vectors across the axis.
struct TangentBasis {
  Eigen::Vector3d first;
  Eigen::Vector3d second;

  explicit TangentBasis(const Eigen::Vector3d& axis) : first(axis.unitOrthogonal()), second(axis.cross(first)) {}
};

Eigen::Matrix<double, 1, 5> change_of_distance(const CameraModel& camera, const CylinderPose& pose,
                                               const TangentBasis& basis, const OutlineMatch& match) {
  const Eigen::Vector3d& p = match.point_in_cam;
  Eigen::Matrix<double, 2, 3> projection;
  projection << camera.fx / p.z(), 0, -camera.fx * p.x() / (p.z() * p.z()),  //
      0, camera.fy / p.z(), -camera.fy * p.y() / (p.z() * p.z());
  const Eigen::RowVector3d by_point = -match.inward.transpose() * projection;
  const Eigen::Vector3d arm = p - pose.center_in_cam;
  Eigen::Matrix<double, 1, 5> row;
  row << by_point, by_point.dot(basis.first.cross(arm)), by_point.dot(basis.second.cross(arm));
  return row;
}

// One Gauss-Newton step's least squares problem, |offset + jacobian moves|; the last row is the prior along the axis.
struct RoundProblem {
  Eigen::Matrix<double, Eigen::Dynamic, 5> jacobian;
  Eigen::VectorXd offset;
};

std::vector<MatchedPoint> match_all(const Outline& outline, std::span<const EdgePoint> points, double gate_px) {
  std::vector<MatchedPoint> matched;
  matched.reserve(points.size());
  for (const EdgePoint& point : points) {
    if (const auto match = outline.match(point, gate_px)) matched.push_back({*match, 1});
  }
  return matched;
}

// 1.4826 times the median absolute residual: the standard deviation, unmoved by outliers.
double robust_sigma(std::vector<MatchedPoint>& matched) {
  std::vector<double> distances;
  distances.reserve(matched.size());
  for (const MatchedPoint& point : matched) distances.push_back(std::abs(point.match.distance_px));
  const auto middle = distances.begin() + static_cast<std::ptrdiff_t>(distances.size() / 2);
  std::nth_element(distances.begin(), middle, distances.end());
  return std::max(kMinEdgeSigmaPx, 1.4826 * *middle);
}

void weigh(std::vector<MatchedPoint>& matched, double sigma) {
  for (MatchedPoint& point : matched) {
    const double scaled = point.match.distance_px / (2.385 * sigma);  // 95 % efficiency for Gaussian residuals
    point.weight = 1 / std::sqrt(1 + scaled * scaled);
  }
}

class Refinement {
 public:
  Refinement(const CameraModel& camera, const PartModel& part, const CylinderPose& start)
      : camera_(camera), part_(part), start_(start), pose_(start) {}

  // One round of matching and solving. None when there is too little to go on, else how far the outline moved in pixels
  // (root mean square over the matched points).
  std::optional<double> solve(std::span<const EdgePoint> points, double gate_px) {
    const auto outline = Outline::of(camera_, part_, pose_);
    if (!outline) return std::nullopt;
    matched_ = match_all(*outline, points, gate_px);
    if (static_cast<int>(matched_.size()) < kMinSupport) return std::nullopt;
    sigma_px_ = robust_sigma(matched_);
    weigh(matched_, sigma_px_);

    const RoundProblem problem = linearised();
    const Matrix5d normal = problem.jacobian.transpose() * problem.jacobian;
    const Vector5d moves = -normal.ldlt().solve(problem.jacobian.transpose() * problem.offset);
    move(moves);
    if (!pose_.center_in_cam.allFinite() || !pose_.axis_in_cam.allFinite()) return std::nullopt;
    return (problem.jacobian * moves).norm() / std::sqrt(static_cast<double>(matched_.size()));
  }

  [[nodiscard]] std::optional<RefinedPose> result(std::span<const EdgePoint> points, const RefineOptions& options) {
    const auto outline = Outline::of(camera_, part_, pose_);
    if (!outline) return std::nullopt;
    matched_ = match_all(*outline, points, options.final_gate_px);
    if (static_cast<int>(matched_.size()) < kMinSupport) return std::nullopt;
    sigma_px_ = robust_sigma(matched_);
    weigh(matched_, sigma_px_);

    RefinedPose refined;
    refined.pose = pose_;
    refined.covariance = covariance(options.common_edge_sigma_px);
    refined.support = static_cast<int>(matched_.size());
    measure_residuals(refined);
    count_seen(*outline, refined);
    return refined;
  }

 private:
  [[nodiscard]] RoundProblem linearised() const {
    const TangentBasis basis(pose_.axis_in_cam);
    const auto count = static_cast<Eigen::Index>(matched_.size());
    RoundProblem problem;
    problem.jacobian.resize(count + 1, 5);
    problem.offset.resize(count + 1);
    for (Eigen::Index i = 0; i < count; ++i) {
      const MatchedPoint& point = matched_[static_cast<std::size_t>(i)];
      problem.jacobian.row(i) = point.weight * change_of_distance(camera_, pose_, basis, point.match);
      problem.offset[i] = point.weight * point.match.distance_px;
    }
    const double prior = sigma_px_ / (part_.height_m / 2);
    problem.jacobian.row(count) << prior * pose_.axis_in_cam.transpose(), 0, 0;
    problem.offset[count] = prior * pose_.axis_in_cam.dot(pose_.center_in_cam - start_.center_in_cam);
    return problem;
  }

  void move(const Vector5d& moves) {
    const TangentBasis basis(pose_.axis_in_cam);
    const Eigen::Vector3d rotation = moves[3] * basis.first + moves[4] * basis.second;
    pose_.center_in_cam += moves.head<3>();
    pose_.axis_in_cam = (pose_.axis_in_cam + rotation.cross(pose_.axis_in_cam)).normalized();
  }

  [[nodiscard]] Eigen::Matrix<double, 6, 6> covariance(double common_edge_sigma_px) const {
    const RoundProblem problem = linearised();
    const Matrix5d normal = problem.jacobian.transpose() * problem.jacobian;
    const Matrix5d inverse = normal.ldlt().solve(Matrix5d::Identity());
    Matrix5d covariance = sigma_px_ * sigma_px_ * inverse;
    for (std::size_t piece = 0; piece < kOutlinePieces; ++piece) {
      Vector5d pull = Vector5d::Zero();
      for (std::size_t i = 0; i < matched_.size(); ++i) {
        if (matched_[i].match.piece == piece) {
          pull += matched_[i].weight * problem.jacobian.row(static_cast<Eigen::Index>(i)).transpose();
        }
      }
      const Vector5d moved = common_edge_sigma_px * (inverse * pull);
      covariance += moved * moved.transpose();
    }
    const TangentBasis basis(pose_.axis_in_cam);
    Eigen::Matrix<double, 6, 5> to_full = Eigen::Matrix<double, 6, 5>::Zero();
    to_full.topLeftCorner<3, 3>().setIdentity();
    to_full.block<3, 1>(3, 3) = basis.first;
    to_full.block<3, 1>(3, 4) = basis.second;
    Eigen::Matrix<double, 6, 6> full = to_full * covariance * to_full.transpose();
    full.bottomRightCorner<3, 3>() += kUnobservableRoll * pose_.axis_in_cam * pose_.axis_in_cam.transpose();
    return full;
  }

  void measure_residuals(RefinedPose& refined) const {
    std::array<double, kOutlinePieces> squares{};
    std::array<int, kOutlinePieces> counts{};
    for (const MatchedPoint& point : matched_) {
      const OutlinePiece piece = point.match.piece;
      squares[piece] += point.match.distance_px * point.match.distance_px;
      ++counts[piece];
    }
    double all = 0;
    for (std::size_t piece = 0; piece < kOutlinePieces; ++piece) {
      refined.piece_rms_px[piece] = counts[piece] > 0 ? std::sqrt(squares[piece] / counts[piece]) : 0;
      all += squares[piece];
    }
    refined.rms_px = std::sqrt(all / refined.support);
  }

  void count_seen(const Outline& outline, RefinedPose& refined) const {
    const auto& stations = outline.stations();
    std::vector<bool> hit(stations.size(), false);
    for (const MatchedPoint& point : matched_) hit[static_cast<std::size_t>(point.match.station)] = true;
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
  CylinderPose start_;
  CylinderPose pose_;
  std::vector<MatchedPoint> matched_;
  double sigma_px_ = 0;
};

}  // namespace

bool RefineOptions::is_valid(std::string* why) const {
  return require_positive(first_gate_px, "refine.first_gate_px", why) &&
         require_positive(final_gate_px, "refine.final_gate_px", why) &&
         require_at_least(rounds, 1, "refine.rounds", why) &&
         require_positive(common_edge_sigma_px, "refine.common_edge_sigma_px", why);
}

std::optional<RefinedPose> refine(const CameraModel& camera, const PartModel& part, const CylinderPose& start,
                                  std::span<const EdgePoint> points, const RefineOptions& options) {
  Refinement refinement(camera, part, start);
  const std::vector<EdgePoint> few = thinned(points, kPointsToComeNear);
  double gate_px = options.first_gate_px;
  for (int round = 0; round < options.rounds; ++round) {
    const auto moved_px = refinement.solve(few, gate_px);
    if (!moved_px) return std::nullopt;
    if (gate_px <= options.final_gate_px && *moved_px < kConvergedPx) break;
    gate_px = std::max(options.final_gate_px, gate_px / 2);
  }
  for (int round = 0; round < kRoundsWithAll; ++round) {
    const auto moved_px = refinement.solve(points, options.final_gate_px);
    if (!moved_px) return std::nullopt;
    if (*moved_px < kConvergedPx) break;
  }
  return refinement.result(points, options);
}

}  // namespace cylpose
