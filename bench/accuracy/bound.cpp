#include "bound.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace cylpose::bench {
namespace {

constexpr double kImageMarginPx = 1;
constexpr double kMatchPx = 1.5;
constexpr std::size_t kEnoughPoints = 20;

Eigen::Matrix<double, 1, 5> change_of_distance(const CameraModel& camera, const CylinderPose& pose,
                                               const ContourSample& sample) {
  const TangentBasis basis(pose.axis_in_cam);
  const Eigen::Vector3d& p = sample.point_in_cam;
  Eigen::Matrix<double, 2, 3> projection;
  projection << camera.fx / p.z(), 0, -camera.fx * p.x() / (p.z() * p.z()),  //
      0, camera.fy / p.z(), -camera.fy * p.y() / (p.z() * p.z());
  const Eigen::RowVector3d by_point = -sample.inward.transpose() * projection;
  const Eigen::Vector3d arm = p - pose.center_in_cam;
  Eigen::Matrix<double, 1, 5> row;
  row << by_point, by_point.dot(basis.first.cross(arm)), by_point.dot(basis.second.cross(arm));
  return row;
}

bool is_inside(const CameraModel& camera, const Eigen::Vector2d& p) {
  return p.x() >= kImageMarginPx && p.y() >= kImageMarginPx && p.x() <= camera.width - 1 - kImageMarginPx &&
         p.y() <= camera.height - 1 - kImageMarginPx;
}

// Reorders the values.
double median(std::vector<double>& values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

double scatter(std::vector<double> distances) {
  const double center = median(distances);
  for (double& distance : distances) distance = std::abs(distance - center);
  return 1.4826 * median(distances);
}

}  // namespace

std::vector<ContourSample> contour_samples(const CameraModel& camera, const PartModel& part, const CylinderPose& pose,
                                           const std::function<bool(const Eigen::Vector2d&)>& is_seen) {
  std::vector<ContourSample> samples;
  const auto outline = Outline::of(camera, part, pose);
  if (!outline) return samples;
  const std::vector<Outline::Station> stations = outline->stations();
  for (std::size_t i = 0; i < stations.size(); ++i) {
    const Outline::Station& here = stations[i];
    if (!is_inside(camera, here.position_px) || !is_seen(here.position_px)) continue;
    // A piece has several stations: at its ends the only neighbour is half of the way.
    const bool has_before = i > 0 && stations[i - 1].piece == here.piece;
    const bool has_after = i + 1 < stations.size() && stations[i + 1].piece == here.piece;
    const Eigen::Vector2d& before = has_before ? stations[i - 1].position_px : here.position_px;
    const Eigen::Vector2d& after = has_after ? stations[i + 1].position_px : here.position_px;
    const Eigen::Vector2d step = (after - before) / (has_before && has_after ? 2 : 1);
    const Outline::Place place = outline->place_of(here);
    samples.push_back(
        {here.piece, here.position_px, place.inward, place.point_in_cam, place.curvature, step.cwiseAbs().maxCoeff()});
  }
  return samples;
}

std::optional<Matrix5d> pose_bound(const CameraModel& camera, const PartModel& part, const CylinderPose& pose,
                                   std::span<const ContourSample> samples, const PieceSigmas& sigmas) {
  Matrix5d information = Matrix5d::Zero();
  for (const ContourSample& sample : samples) {
    const Eigen::Matrix<double, 1, 5> row = change_of_distance(camera, pose, sample);
    const double sigma = sigmas[sample.piece];
    information += sample.edge_pixels / (sigma * sigma) * row.transpose() * row;
  }
  const double prior = part.height_m / 2;
  information.topLeftCorner<3, 3>() += pose.axis_in_cam * pose.axis_in_cam.transpose() / (prior * prior);
  // Metres and radians differ less than what is known does from what is not.
  const Eigen::SelfAdjointEigenSolver<Matrix5d> eigen(information);
  if (!(eigen.eigenvalues()[0] > 1e-12 * eigen.eigenvalues()[4])) return std::nullopt;
  return information.ldlt().solve(Matrix5d::Identity());
}

std::optional<PieceSigmas> edge_scatter(const Outline& truth, std::span<const EdgePoint> points) {
  std::array<std::vector<double>, kOutlinePieces> of_piece;
  std::vector<double> all;
  for (const EdgePoint& point : points) {
    const auto match = truth.match(point, kMatchPx);
    if (!match) continue;
    of_piece[match->piece].push_back(match->distance_px);
    all.push_back(match->distance_px);
  }
  if (all.size() < kEnoughPoints) return std::nullopt;
  const double of_all = scatter(all);
  PieceSigmas sigmas{};
  std::transform(of_piece.begin(), of_piece.end(), sigmas.begin(), [&](const std::vector<double>& distances) {
    return distances.size() < kEnoughPoints ? of_all : scatter(distances);
  });
  return sigmas;
}

}  // namespace cylpose::bench
