#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cylpose/curved_border.hpp>
#include <cylpose/outline.hpp>
#include <numbers>
#include <numeric>

namespace cylpose {
namespace {

constexpr int kMinStations = 6;
constexpr int kMaxStations = 96;
// An edge point belongs to a piece of the outline only if their normals differ by less than this (cosine of 37
// degrees).
constexpr double kMinNormalCosine = 0.8;
// The foot point on an arc is found in steps along the tangent; after a step shorter than this the distance is exact to
// 0.001 px.
constexpr double kFootPointStepPx = 0.2;
constexpr int kMaxFootPointSteps = 4;
// By this factor farther outside than matches may be: perspective makes the first guess of the distance inexact.
constexpr double kFarOutside = 1.5;

Eigen::Vector2d perpendicular(const Eigen::Vector2d& v) {
  return {-v.y(), v.x()};
}

// On the unit circle: the sum of two angles.
Eigen::Vector2d turned(const Eigen::Vector2d& by, const Eigen::Vector2d& v) {
  return {by.x() * v.x() - by.y() * v.y(), by.y() * v.x() + by.x() * v.y()};
}

Eigen::Vector2d unit_vector(double angle) {
  return {std::cos(angle), std::sin(angle)};
}

ImageLine line_through(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& inside) {
  Eigen::Vector2d normal = perpendicular(b - a).normalized();
  if (normal.dot(inside - a) < 0) normal = -normal;
  return {normal, normal.dot(a)};
}

}  // namespace

Outline::CircleImage::Place Outline::CircleImage::at(const Eigen::Vector2d& on_circle) const {
  const Eigen::Vector2d ahead = perpendicular(on_circle);
  const double scale = 1 / (1 + w.dot(on_circle));
  const Eigen::Vector2d offset = scale * (on_circle.x() * by_cosine + on_circle.y() * by_sine);
  return {middle + offset, scale * (ahead.x() * by_cosine + ahead.y() * by_sine - w.dot(ahead) * offset)};
}

// The determinant of the first and the second derivative is that of the two columns over the third power of the
// denominator.
double Outline::CircleImage::curvature(const Eigen::Vector2d& on_circle, const Place& place) const {
  const double columns = std::abs(by_cosine.x() * by_sine.y() - by_cosine.y() * by_sine.x());
  const double length = (1 + w.dot(on_circle)) * place.tangent.norm();
  return columns / (length * length * length);
}

// A place in the coordinates in which the circle is the unit circle.
Outline::CircleImage::InCircle Outline::CircleImage::in_circle(const Eigen::Vector2d& position_px) const {
  const Eigen::Vector2d offset = position_px - middle;
  const Eigen::Vector2d along = by_sine - w.y() * offset;
  const Eigen::Vector2d toward = by_cosine - w.x() * offset;
  const double per_sine = 1 / along.squaredNorm();
  const double sine = offset.dot(along) * per_sine;
  const double shear = toward.dot(along) * per_sine;
  const Eigen::Vector2d across = toward - shear * along;
  const double across_squared = across.squaredNorm();
  const double cosine = offset.dot(across) / across_squared;
  InCircle in;
  in.on_flat = sine;
  in.thickness_squared = across_squared;
  in.place = {cosine, sine - cosine * shear};
  in.squared = in.place.squaredNorm();
  in.by_cosine = across / across_squared;
  in.by_sine = per_sine * along - shear * in.by_cosine;
  return in;
}

// Of the distance from the circle's image, to first order; negative inside.
double Outline::CircleImage::outside_px(const Eigen::Vector2d& position_px) const {
  const InCircle in = in_circle(position_px);
  const double radius = std::sqrt(in.squared);
  return (radius - 1) * 2 * radius / in.slope().norm();
}

// Cosine and sine of an angle near the foot point's, exact for points on the ellipse; none for points clearly farther
// outside than `max_distance_px`. Across a flat ellipse, whose long axis is nearly by_sine, the place along that axis
// tells more than the direction from the middle.
std::optional<Eigen::Vector2d> Outline::CircleImage::first_guess(const Eigen::Vector2d& position_px,
                                                                 double max_distance_px, double cosine_sign) const {
  const InCircle in = in_circle(position_px);
  const double flat = 2 * max_distance_px;
  if (in.thickness_squared > flat * flat) {
    // The square is convex: over its slope, what it is above 1 is no more than the distance.
    const double reach = kFarOutside * max_distance_px;
    const double excess = in.squared - 1;
    if (excess > 0 && excess * excess > reach * reach * in.slope().squaredNorm()) return std::nullopt;
    if (in.squared > 0) return in.place / std::sqrt(in.squared);
  }
  const double cut = std::clamp(in.on_flat, -1.0, 1.0);
  return Eigen::Vector2d(cosine_sign * std::sqrt(1 - cut * cut), cut);
}

std::optional<Outline> Outline::of(const CameraModel& camera, const PartModel& part, const CylinderPose& pose) {
  const auto arcs = outline_arcs(pose, part.radius_m, part.height_m);
  if (!arcs) return std::nullopt;
  return Outline(camera, part, pose, *arcs);
}

Outline::Outline(const CameraModel& camera, const PartModel& part, const CylinderPose& pose, const OutlineArcs& arcs)
    : radius_m_(part.radius_m), arcs_(arcs) {
  const Eigen::Vector2d middle = ideal_pixel(camera, pose.center_in_cam);
  const Eigen::Vector3d axis = pose.axis_in_cam * part.height_m;
  for (const std::size_t side : {0U, 1U}) {
    // Arc 0 starts at side 1 and ends at side 0 (angles -+touch); arc 1 the other way round.
    side_ends_[side][0] = arcs.point(0, arcs.start[0] + (side == 0 ? arcs.span[0] : 0), radius_m_);
    side_ends_[side][1] = side_ends_[side][0] + axis;
    const Eigen::Vector2d from = ideal_pixel(camera, side_ends_[side][0]);
    const Eigen::Vector2d to = ideal_pixel(camera, side_ends_[side][1]);
    sides_[side] = line_through(from, to, middle);
    side_from_[side] = from;
    side_along_[side] = (to - from) / (to - from).squaredNorm();
  }
  for (const std::size_t base : {0U, 1U}) {
    circles_[base] = image_of_circle(camera, base);
    arc_middle_[base] = unit_vector(arcs.start[base] + arcs.span[base] / 2);
    arc_half_[base] = unit_vector(std::abs(arcs.span[base]) / 2);
    // Beyond the arc is outside. (The other base's centre is no guide: along the axis it lies on the arc's side.)
    const Eigen::Vector2d from = ideal_pixel(camera, side_ends_[0][base]);
    const Eigen::Vector2d to = ideal_pixel(camera, side_ends_[1][base]);
    chords_[base] = line_through(from, to, from + to - circles_[base].at(arc_middle_[base]).position);
    arc_turn_[base] =
        perpendicular(circles_[base].at(arc_middle_[base]).tangent).dot(chords_[base].normal) > 0 ? 1 : -1;
  }
  count_stations();
}

Outline::CircleImage Outline::image_of_circle(const CameraModel& camera, std::size_t base) const {
  const Eigen::Vector3d& center = arcs_.centers[base];
  const Eigen::Vector2d middle = center.head<2>() / center.z();
  const Eigen::Array2d focal(camera.fx, camera.fy);
  const auto change = [&](const Eigen::Vector3d& by) -> Eigen::Vector2d {
    return (radius_m_ / center.z() * (by.head<2>() - middle * by.z()).array() * focal).matrix();
  };
  return {ideal_pixel(camera, center), change(arcs_.toward), change(arcs_.across),
          radius_m_ / center.z() * Eigen::Vector2d(arcs_.toward.z(), arcs_.across.z())};
}

double Outline::angle_at(std::size_t base, double share) const {
  return arcs_.start[base] + share * arcs_.span[base];
}

void Outline::count_stations() {
  const auto count = [](double length_px) {
    // Compared as numbers: a length may be infinite or NaN where an end lies in the plane of the camera.
    const double wanted = std::min<double>(length_px / kStationSpacingPx, kMaxStations);
    return wanted > kMinStations ? static_cast<int>(wanted) : kMinStations;
  };
  for (const std::size_t side : {0U, 1U}) stations_of_[side] = count(1 / side_along_[side].norm());
  for (const std::size_t base : {0U, 1U}) {
    const auto position = [&](double share) { return circles_[base].at(unit_vector(angle_at(base, share))).position; };
    const Eigen::Vector2d middle = position(0.5);
    stations_of_[kBase0 + base] = count((middle - position(0)).norm() + (position(1) - middle).norm());
  }
}

std::size_t Outline::station_count() const {
  return static_cast<std::size_t>(std::accumulate(stations_of_.begin(), stations_of_.end(), 0));
}

std::vector<Outline::Station> Outline::stations() const {
  std::vector<Station> stations;
  stations.reserve(station_count());
  for (const OutlinePiece piece : {kSide0, kSide1, kBase0, kBase1}) {
    const int count = stations_of_[piece];
    for (int i = 0; i < count; ++i) {
      const double share = (i + 0.5) / count;
      if (piece == kSide0 || piece == kSide1) {
        const Eigen::Vector2d& along = side_along_[piece];
        stations.push_back({piece, share, side_from_[piece] + share * along / along.squaredNorm()});
      } else {
        const std::size_t base = piece - kBase0;
        stations.push_back({piece, share, circles_[base].at(unit_vector(angle_at(base, share))).position});
      }
    }
  }
  return stations;
}

Outline::Place Outline::place_of(const Station& station) const {
  if (station.piece == kSide0 || station.piece == kSide1) {
    const Eigen::Vector3d& from = side_ends_[station.piece][0];
    const Eigen::Vector3d& to = side_ends_[station.piece][1];
    const double in_space = station.share * from.z() / ((1 - station.share) * to.z() + station.share * from.z());
    return {from + in_space * (to - from), sides_[station.piece].normal, 0};
  }
  const std::size_t base = station.piece - kBase0;
  const double angle = angle_at(base, station.share);
  const CircleImage::Place place = circles_[base].at(unit_vector(angle));
  return {arcs_.point(static_cast<int>(base), angle, radius_m_),
          arc_turn_[base] * perpendicular(place.tangent).normalized(),
          circles_[base].curvature(unit_vector(angle), place)};
}

double Outline::share_of(const OutlineMatch& match) const {
  if (match.piece == kSide0 || match.piece == kSide1) return match.share;
  const std::size_t base = match.piece - kBase0;
  const Eigen::Vector2d from_middle = turned({arc_middle_[base].x(), -arc_middle_[base].y()}, match.on_circle);
  return 0.5 + std::atan2(from_middle.y(), from_middle.x()) / arcs_.span[base];
}

std::size_t Outline::station_of(const OutlineMatch& match) const {
  const double share = share_of(match);
  int first = 0;
  for (std::size_t piece = 0; piece < match.piece; ++piece) first += stations_of_[piece];
  const int count = stations_of_[match.piece];
  return static_cast<std::size_t>(first + std::clamp(static_cast<int>(share * count), 0, count - 1));
}

Eigen::Vector3d Outline::point_on_base(const OutlineMatch& match) const {
  return arcs_.centers[match.piece - kBase0] +
         radius_m_ * (match.on_circle.x() * arcs_.toward + match.on_circle.y() * arcs_.across);
}

Eigen::Vector3d Outline::end_of_side(std::size_t side, std::size_t base) const {
  return side_ends_[side][base];
}

std::optional<OutlineMatch> Outline::match(const EdgePoint& edge, double max_distance_px) const {
  std::optional<OutlineMatch> best = match_side(0, edge, max_distance_px);
  const auto keep_nearer = [&](const std::optional<OutlineMatch>& candidate) {
    if (candidate && (!best || std::abs(candidate->distance_px) < std::abs(best->distance_px))) best = candidate;
  };
  keep_nearer(match_side(1, edge, max_distance_px));
  if (best) return best;
  for (const std::size_t base : {0U, 1U}) keep_nearer(match_base(base, edge, max_distance_px));
  return best;
}

std::optional<OutlineMatch> Outline::match_side(std::size_t side, const EdgePoint& edge, double max_distance_px) const {
  const ImageLine& line = sides_[side];
  const double distance = signed_distance(line, edge.position_px);
  if (std::abs(distance) > max_distance_px || line.normal.dot(edge.inward) < kMinNormalCosine) return std::nullopt;
  const double share = side_along_[side].dot(edge.position_px - side_from_[side]);
  if (!(share >= 0 && share <= 1)) return std::nullopt;
  return OutlineMatch{static_cast<OutlinePiece>(side), share, Eigen::Vector2d::Zero(), line.normal, distance, edge.cue};
}

Eigen::Vector2d Outline::cut_to_arc(std::size_t base, const Eigen::Vector2d& on_circle) const {
  const Eigen::Vector2d& middle = arc_middle_[base];
  const Eigen::Vector2d& half = arc_half_[base];
  if (middle.dot(on_circle) >= half.x()) return on_circle;
  const bool ahead = middle.x() * on_circle.y() - middle.y() * on_circle.x() > 0;
  return turned(middle, {half.x(), ahead ? half.y() : -half.y()});
}

std::optional<OutlineMatch> Outline::match_base(std::size_t base, const EdgePoint& edge, double max_distance_px) const {
  const Eigen::Vector2d& position_px = edge.position_px;
  if (signed_distance(chords_[base], position_px) > max_distance_px + 1) return std::nullopt;
  const CircleImage& circle = circles_[base];
  const auto guess = circle.first_guess(position_px, max_distance_px, arc_middle_[base].x() > 0 ? 1 : -1);
  if (!guess) return std::nullopt;
  Eigen::Vector2d on_circle = cut_to_arc(base, *guess);
  CircleImage::Place place = circle.at(on_circle);
  for (int step = 0; step < kMaxFootPointSteps; ++step) {
    const double squared = place.tangent.squaredNorm();
    const double change = place.tangent.dot(position_px - place.position) / squared;
    on_circle = cut_to_arc(base, (on_circle + change * perpendicular(on_circle)).normalized());
    place = circle.at(on_circle);
    if (change * change * squared < kFootPointStepPx * kFootPointStepPx) break;
  }
  const double curvature = circle.curvature(on_circle, place);
  if (curvature > kMaxCurvature) return std::nullopt;
  const Eigen::Vector2d offset = position_px - place.position;
  const Eigen::Vector2d inward = arc_turn_[base] * perpendicular(place.tangent).normalized();
  const double distance = inward.dot(offset) - inward_shift_px(curvature);
  const double reach = max_distance_px + 1;
  if (!(std::abs(distance) <= max_distance_px) || inward.dot(edge.inward) < kMinNormalCosine ||
      offset.squaredNorm() > reach * reach) {
    return std::nullopt;
  }
  return OutlineMatch{static_cast<OutlinePiece>(kBase0 + base), 0, on_circle, inward, distance, edge.cue};
}

double Outline::bulge_px(std::size_t base) const {
  return -signed_distance(chords_[base], circles_[base].at(arc_middle_[base]).position);
}

double Outline::area_px() const {
  // Once around: arc 0 from side 1 to side 0, then arc 1 back.
  constexpr int kPerArc = 24;
  std::vector<Eigen::Vector2d> corners;
  corners.reserve(std::size_t{2} * kPerArc);
  for (const std::size_t base : {0U, 1U}) {
    for (int i = 0; i < kPerArc; ++i) {
      corners.push_back(circles_[base].at(unit_vector(angle_at(base, i / (kPerArc - 1.0)))).position);
    }
  }
  double twice = 0;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Eigen::Vector2d& a = corners[i];
    const Eigen::Vector2d& b = corners[(i + 1) % corners.size()];
    twice += a.x() * b.y() - a.y() * b.x();
  }
  return std::abs(twice) / 2;
}

bool Outline::within(const Eigen::Vector2d& position_px, double margin_px) const {
  const auto inside = [&](const ImageLine& line) { return signed_distance(line, position_px) >= margin_px; };
  return inside(sides_[0]) && inside(sides_[1]) && inside(chords_[0]) && inside(chords_[1]);
}

bool Outline::beyond(const Eigen::Vector2d& position_px, double margin_px) const {
  return !within(position_px, -margin_px) && circles_[0].outside_px(position_px) > margin_px &&
         circles_[1].outside_px(position_px) > margin_px;
}

}  // namespace cylpose
