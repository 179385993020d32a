#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cylpose/outline.hpp>

namespace cylpose {
namespace {

constexpr double kStationSpacingPx = 3;
constexpr int kMinStations = 6;
constexpr int kMaxStations = 96;
// An edge point belongs to a piece of the outline only if their normals differ by less than this (cosine of 37
// degrees).
constexpr double kMinNormalCosine = 0.8;

Eigen::Vector2d perpendicular(const Eigen::Vector2d& v) {
  return {-v.y(), v.x()};
}

ImageLine line_through(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& inside) {
  Eigen::Vector2d normal = perpendicular(b - a).normalized();
  if (normal.dot(inside - a) < 0) normal = -normal;
  return {normal, normal.dot(a)};
}

}  // namespace

std::optional<Outline> Outline::of(const CameraModel& camera, const PartModel& part, const CylinderPose& pose) {
  const auto arcs = outline_arcs(pose, part.radius_m, part.height_m);
  if (!arcs) return std::nullopt;
  return Outline(camera, part, pose, *arcs);
}

Outline::Outline(const CameraModel& camera, const PartModel& part, const CylinderPose& pose, const OutlineArcs& arcs)
    : camera_(camera), radius_m_(part.radius_m), height_m_(part.height_m), pose_(pose), arcs_(arcs) {
  const Eigen::Vector2d middle = ideal_pixel(camera_, pose.center_in_cam);
  const Eigen::Vector3d half_axis = pose.axis_in_cam * (height_m_ / 2);
  for (const std::size_t side : {0U, 1U}) {
    // Arc 0 starts at side 1 and ends at side 0 (angles -+touch); arc 1 the other way round.
    touch_[side] = arcs.point(0, arcs.start[0] + (side == 0 ? arcs.span[0] : 0), radius_m_) + half_axis;
    sides_[side] = line_through(ideal_pixel(camera_, touch_[side] - half_axis),
                                ideal_pixel(camera_, touch_[side] + half_axis), middle);
  }
  for (const std::size_t base : {0U, 1U}) {
    const double outward = base == 0 ? -1 : 1;
    chords_[base] = line_through(ideal_pixel(camera_, touch_[0] + outward * half_axis),
                                 ideal_pixel(camera_, touch_[1] + outward * half_axis),
                                 ideal_pixel(camera_, pose.center_in_cam - outward * half_axis));
  }
  for (const int base : {0, 1}) {
    const auto b = static_cast<std::size_t>(base);
    const Eigen::Vector2d tangent = arc_tangent(base, arcs.start[b] + arcs.span[b] / 2);
    arc_turn_[b] = perpendicular(tangent).dot(chords_[b].normal) > 0 ? 1 : -1;
  }
  first_station_[0] = 0;
  add_stations(kSide0, -height_m_ / 2, height_m_ / 2);
  add_stations(kSide1, -height_m_ / 2, height_m_ / 2);
  add_stations(kBase0, arcs.start[0], arcs.start[0] + arcs.span[0]);
  add_stations(kBase1, arcs.start[1], arcs.start[1] + arcs.span[1]);
}

Eigen::Vector3d Outline::point_at(OutlinePiece piece, double place) const {
  if (piece == kSide0 || piece == kSide1) return touch_[piece] + place * pose_.axis_in_cam;
  return arcs_.point(piece == kBase0 ? 0 : 1, place, radius_m_);
}

Eigen::Vector2d Outline::arc_tangent(int base, double angle) const {
  const Eigen::Vector3d point = arcs_.point(base, angle, radius_m_);
  const Eigen::Vector3d along = radius_m_ * (-std::sin(angle) * arcs_.toward + std::cos(angle) * arcs_.across);
  return {camera_.fx * (along.x() - point.x() / point.z() * along.z()) / point.z(),
          camera_.fy * (along.y() - point.y() / point.z() * along.z()) / point.z()};
}

void Outline::add_stations(OutlinePiece piece, double from, double to) {
  const double middle = (from + to) / 2;
  const Eigen::Vector2d a = ideal_pixel(camera_, point_at(piece, from));
  const Eigen::Vector2d b = ideal_pixel(camera_, point_at(piece, middle));
  const Eigen::Vector2d c = ideal_pixel(camera_, point_at(piece, to));
  const double length = (b - a).norm() + (c - b).norm();
  // Compared as numbers: a length may be infinite or NaN where an end lies in the plane of the camera.
  const double wanted = std::min<double>(length / kStationSpacingPx, kMaxStations);
  const int count = wanted > kMinStations ? static_cast<int>(wanted) : kMinStations;
  for (int i = 0; i < count; ++i) {
    const double place = from + (to - from) * (i + 0.5) / count;
    stations_.push_back({piece, ideal_pixel(camera_, point_at(piece, place)), place});
  }
  first_station_[piece + 1] = static_cast<int>(stations_.size());
}

std::optional<OutlineMatch> Outline::match(const EdgePoint& edge, double max_distance_px) const {
  std::optional<OutlineMatch> best;
  const auto keep_nearer = [&](const std::optional<OutlineMatch>& candidate) {
    if (candidate && (!best || std::abs(candidate->distance_px) < std::abs(best->distance_px))) best = candidate;
  };
  for (const int side : {0, 1}) keep_nearer(match_side(side, edge, max_distance_px));
  if (best) return best;
  for (const int base : {0, 1}) keep_nearer(match_base(base, edge, max_distance_px));
  return best;
}

std::optional<OutlineMatch> Outline::match_side(int side, const EdgePoint& edge, double max_distance_px) const {
  const auto s = static_cast<std::size_t>(side);
  const double distance = signed_distance(sides_[s], edge.position_px);
  if (std::abs(distance) > max_distance_px || sides_[s].normal.dot(edge.inward) < kMinNormalCosine) return std::nullopt;
  // The foot point's ray lies in the plane of touch, spanned by the axis direction and the touch point's part across
  // it.
  const Eigen::Vector2d foot = edge.position_px - distance * sides_[s].normal;
  const Eigen::Vector3d ray = ideal_ray(camera_, foot);
  const double along_touch = touch_[s].dot(pose_.axis_in_cam);
  const Eigen::Vector3d across = touch_[s] - along_touch * pose_.axis_in_cam;
  const double place = ray.dot(pose_.axis_in_cam) / ray.dot(across) * across.squaredNorm() - along_touch;
  const double share = place / height_m_ + 0.5;
  if (!(share >= 0 && share <= 1)) return std::nullopt;
  const int count = first_station_[s + 1] - first_station_[s];
  const int station = first_station_[s] + std::min(count - 1, static_cast<int>(share * count));
  const auto piece = static_cast<OutlinePiece>(side);
  return OutlineMatch{piece, station, point_at(piece, place), sides_[s].normal, distance};
}

std::optional<OutlineMatch> Outline::match_base(int base, const EdgePoint& edge, double max_distance_px) const {
  const auto b = static_cast<std::size_t>(base);
  if (signed_distance(chords_[b], edge.position_px) > max_distance_px + 1) return std::nullopt;
  const auto piece = static_cast<OutlinePiece>(kBase0 + b);
  int nearest = -1;
  double nearest_squared = std::numeric_limits<double>::infinity();
  for (int i = first_station_[b + 2]; i < first_station_[b + 3]; ++i) {
    const double squared = (stations_[static_cast<std::size_t>(i)].position_px - edge.position_px).squaredNorm();
    if (squared < nearest_squared) {
      nearest_squared = squared;
      nearest = i;
    }
  }
  const double reach = max_distance_px + 2 * kStationSpacingPx;
  if (nearest_squared > reach * reach) return std::nullopt;

  // From the nearest station along the tangent to the foot point; two steps leave less than 0.001 px.
  double angle = stations_[static_cast<std::size_t>(nearest)].place;
  const double low = std::min(arcs_.start[b], arcs_.start[b] + arcs_.span[b]);
  const double high = std::max(arcs_.start[b], arcs_.start[b] + arcs_.span[b]);
  Eigen::Vector3d point;
  Eigen::Vector2d position;
  Eigen::Vector2d tangent;
  for (int step = 0; step < 3; ++step) {
    point = arcs_.point(base, angle, radius_m_);
    position = ideal_pixel(camera_, point);
    tangent = arc_tangent(base, angle);
    if (step < 2) {
      const double change = tangent.dot(edge.position_px - position) / tangent.squaredNorm();
      angle = std::clamp(angle + change, low, high);
    }
  }
  const Eigen::Vector2d inward = arc_turn_[b] * perpendicular(tangent).normalized();
  const double distance = inward.dot(edge.position_px - position);
  if (std::abs(distance) > max_distance_px || inward.dot(edge.inward) < kMinNormalCosine ||
      (edge.position_px - position).norm() > max_distance_px + 1) {
    return std::nullopt;
  }
  return OutlineMatch{piece, nearest, point, inward, distance};
}

double Outline::area_px() const {
  double twice = 0;
  const auto corner = [&](std::size_t i) -> Eigen::Vector2d {
    // Once around: arc 0 from side 1 to side 0, then arc 1 back.
    const auto from_base0 = static_cast<std::size_t>(first_station_[2]);
    return stations_[from_base0 + i % (stations_.size() - from_base0)].position_px;
  };
  for (std::size_t i = 0; i < stations_.size() - static_cast<std::size_t>(first_station_[2]); ++i) {
    const Eigen::Vector2d a = corner(i);
    const Eigen::Vector2d b = corner(i + 1);
    twice += a.x() * b.y() - a.y() * b.x();
  }
  return std::abs(twice) / 2;
}

bool Outline::within(const Eigen::Vector2d& position_px, double margin_px) const {
  const auto inside = [&](const ImageLine& line) { return signed_distance(line, position_px) >= margin_px; };
  return inside(sides_[0]) && inside(sides_[1]) && inside(chords_[0]) && inside(chords_[1]);
}

}  // namespace cylpose
