#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <cylpose/line.hpp>

#include "option_check.hpp"

namespace cylpose {
namespace {

FittedLine fit_all(std::span<const EdgePoint> points, const Chain& chain) {
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  Eigen::Vector2d inward = Eigen::Vector2d::Zero();
  for (const int i : chain) {
    mean += points[static_cast<std::size_t>(i)].position_px;
    inward += points[static_cast<std::size_t>(i)].inward;
  }
  mean /= static_cast<double>(chain.size());
  Eigen::Matrix2d scatter = Eigen::Matrix2d::Zero();
  for (const int i : chain) {
    const Eigen::Vector2d offset = points[static_cast<std::size_t>(i)].position_px - mean;
    scatter += offset * offset.transpose();
  }
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> eigen;
  eigen.computeDirect(scatter);
  Eigen::Vector2d normal = eigen.eigenvectors().col(0);
  if (normal.dot(inward) < 0) normal = -normal;

  FittedLine fitted;
  fitted.line = {normal, normal.dot(mean)};
  fitted.rms_px = std::sqrt(std::max(0.0, eigen.eigenvalues()[0]) / static_cast<double>(chain.size()));
  fitted.points = chain;
  const Eigen::Vector2d direction(normal.y(), -normal.x());
  double first = 0;
  double last = 0;
  for (const int i : chain) {
    const double along = direction.dot(points[static_cast<std::size_t>(i)].position_px - mean);
    first = std::min(first, along);
    last = std::max(last, along);
  }
  fitted.from = mean + first * direction;
  fitted.to = mean + last * direction;
  return fitted;
}

bool may_be_one(const FittedLine& a, const FittedLine& b, const LineOptions& options) {
  if (a.line.normal.dot(b.line.normal) < std::cos(options.merge_angle_rad)) return false;
  // Far apart the common fit below could still be good for a short line: its middle must lie near the longer one.
  const Eigen::Vector2d middle = (b.from + b.to) / 2;
  return std::abs(signed_distance(a.line, middle)) < 4 * options.merge_rms_px;
}

}  // namespace

bool LineOptions::is_valid(std::string* why) const {
  return require_positive(max_rms_px, "line.max_rms_px", why) &&
         require_positive(merge_angle_rad, "line.merge_angle_rad", why) &&
         require_positive(merge_rms_px, "line.merge_rms_px", why);
}

FittedLine fit_line(std::span<const EdgePoint> points, const Chain& chain) {
  FittedLine fitted = fit_all(points, chain);
  Chain near;
  near.reserve(chain.size());
  for (const int i : chain) {
    if (std::abs(signed_distance(fitted.line, points[static_cast<std::size_t>(i)].position_px)) <= 3 * fitted.rms_px)
      near.push_back(i);
  }
  return near.size() == chain.size() || near.size() < 2 ? fitted : fit_all(points, near);
}

std::vector<FittedLine> find_lines(std::span<const EdgePoint> points, std::span<const Chain> segments,
                                   const LineOptions& options) {
  const auto by_support = [](const FittedLine& a, const FittedLine& b) { return a.points.size() > b.points.size(); };
  std::vector<FittedLine> pieces;
  for (const Chain& segment : segments) {
    FittedLine line = fit_line(points, segment);
    if (line.rms_px <= options.max_rms_px) pieces.push_back(std::move(line));
  }
  std::stable_sort(pieces.begin(), pieces.end(), by_support);

  std::vector<FittedLine> lines;
  for (FittedLine& piece : pieces) {
    bool merged = false;
    for (FittedLine& line : lines) {
      if (!may_be_one(line, piece, options)) continue;
      Chain both = line.points;
      both.insert(both.end(), piece.points.begin(), piece.points.end());
      FittedLine common = fit_all(points, both);
      if (common.rms_px <= options.merge_rms_px) {
        line = std::move(common);
        merged = true;
        break;
      }
    }
    if (!merged) lines.push_back(std::move(piece));
  }
  std::stable_sort(lines.begin(), lines.end(), by_support);
  return lines;
}

}  // namespace cylpose
