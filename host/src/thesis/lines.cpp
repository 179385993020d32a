// Section 3.3.2 and the second half of algorithm 5.4: lines from pieces of edges, and the two that are the sides.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cylpose/thesis.hpp>
#include <iterator>
#include <numbers>
#include <utility>

namespace cylpose {
namespace {

constexpr double kPi = std::numbers::pi;

// Angle between two directions that have no sign, in [-pi/2, pi/2].
double turn_between(double from_rad, double to_rad) {
  return std::remainder(to_rad - from_rad, kPi);
}

// The line's delta when its normal is turned by half a turn as often as it takes to be near `rho_rad`.
double delta_beside(const ThesisLine& line, double rho_rad) {
  return std::cos(line.rho_rad - rho_rad) < 0 ? -line.delta_px : line.delta_px;
}

bool equal(const ThesisLine& a, const ThesisLine& b, const ThesisOptions& options) {
  return std::abs(turn_between(a.rho_rad, b.rho_rad)) <= options.equal_angle_rad &&
         std::abs(delta_beside(b, a.rho_rad) - a.delta_px) <= options.equal_distance_px;
}

// The thesis's equalLines: parameters weighted by support, and the supports added.
void join(ThesisLine* line, ThesisLine other) {
  const double total = static_cast<double>(line->points.size() + other.points.size());
  const double share = static_cast<double>(other.points.size()) / total;
  const double other_delta = delta_beside(other, line->rho_rad);
  line->delta_px += share * (other_delta - line->delta_px);
  line->rho_rad += share * turn_between(line->rho_rad, other.rho_rad);
  line->squared_error_px2 += share * (other.squared_error_px2 - line->squared_error_px2);
  line->points.insert(line->points.end(), std::make_move_iterator(other.points.begin()),
                      std::make_move_iterator(other.points.end()));
}

bool better_supported(const ThesisLine& a, const ThesisLine& b) {
  return a.points.size() > b.points.size();
}

}  // namespace

Eigen::Vector2d ThesisLine::normal() const {
  return {std::cos(rho_rad), std::sin(rho_rad)};
}

ThesisLine thesis_fitted_line(std::vector<Eigen::Vector2d> points) {
  const auto count = static_cast<double>(points.size());
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  for (const Eigen::Vector2d& point : points) mean += point / count;
  double xx = 0;
  double xy = 0;
  double yy = 0;
  for (const Eigen::Vector2d& point : points) {
    const Eigen::Vector2d offset = point - mean;
    xx += offset.x() * offset.x();
    xy += offset.x() * offset.y();
    yy += offset.y() * offset.y();
  }
  // Equation 3.4, with sums about the mean instead of differences of large sums. y = m x + b has the normal (-m, 1);
  // x = m y + c has the normal (1, -m), and m = 0 is the thesis's special case x = c = mean(x).
  ThesisLine line;
  if (yy > xx) {
    line.rho_rad = std::atan2(-xy / yy, 1);
  } else {
    line.rho_rad = std::atan2(1, xx > 0 ? -xy / xx : 0);
  }
  const Eigen::Vector2d normal = line.normal();
  line.delta_px = normal.dot(mean);
  for (const Eigen::Vector2d& point : points) {
    const double distance = normal.dot(point) - line.delta_px;
    line.squared_error_px2 += distance * distance / count;
  }
  line.points = std::move(points);
  return line;
}

bool is_straight(const ThesisLine& line, const ThesisOptions& options) {
  const bool upright = std::abs(std::remainder(line.rho_rad, kPi / 2)) <= options.upright_tolerance_rad;
  return line.squared_error_px2 < options.max_squared_error_px2 * (upright ? options.upright_error_factor : 1);
}

std::vector<ThesisLine> thesis_combined(std::vector<ThesisLine> lines, const ThesisOptions& options) {
  std::stable_sort(lines.begin(), lines.end(), better_supported);
  std::vector<ThesisLine> combined;
  for (ThesisLine& line : lines) {
    const auto same =
        std::find_if(combined.begin(), combined.end(), [&](const ThesisLine& c) { return equal(c, line, options); });
    if (same == combined.end()) {
      combined.push_back(std::move(line));
    } else {
      join(&*same, std::move(line));
    }
  }
  std::stable_sort(combined.begin(), combined.end(), better_supported);
  return combined;
}

std::optional<std::array<ThesisLine, 2>> thesis_candidates(const std::vector<ThesisLine>& lines,
                                                           const RegionStatistics& region, const ThesisOptions& options,
                                                           std::string* why) {
  std::vector<const ThesisLine*> sides;
  for (const ThesisLine& line : lines) {
    // A line runs at right angles to its normal.
    const double angle = turn_between(region.orientation_rad(), line.rho_rad + kPi / 2);
    if (std::abs(angle) <= options.max_angle_to_region_rad) sides.push_back(&line);
  }
  if (sides.size() < 2) {
    if (why != nullptr) {
      *why = fmt::format("{} of {} straight lines run along the region (eccentricity {:.2f}); two are needed",
                         sides.size(), lines.size(), region.eccentricity());
    }
    return std::nullopt;
  }
  // The second line is the one with the second-best support, unless others come close; then the angle decides.
  const auto clear = [&](const ThesisLine* line) {
    return static_cast<double>(sides[1]->points.size()) >=
           options.clear_support_ratio * static_cast<double>(line->points.size());
  };
  const auto rivals_end = std::find_if(sides.begin() + 2, sides.end(), clear);
  const auto second = std::min_element(sides.begin() + 1, rivals_end, [&](const ThesisLine* a, const ThesisLine* b) {
    return std::abs(turn_between(sides[0]->rho_rad, a->rho_rad)) <
           std::abs(turn_between(sides[0]->rho_rad, b->rho_rad));
  });
  return std::array<ThesisLine, 2>{*sides[0], **second};
}

}  // namespace cylpose
