#include "canvas.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <sstream>
#include <utility>

namespace cylpose {
namespace {

const cv::Scalar kBlack(0, 0, 0);

// Diagonal of a picture on which lines are one pixel wide and letters 8 pixels high: 640 x 400.
constexpr double kSmallDiagonal = 755;
constexpr double kSmallTextScale = 0.4;

// Far outside the picture OpenCV's fixed-point coordinates would overflow.
constexpr double kFarAway = 1e5;

bool drawable(const Eigen::Vector2d& point) {
  return point.allFinite() && point.cwiseAbs().maxCoeff() < kFarAway;
}

cv::Point2d to_cv(const Eigen::Vector2d& point) {
  return {point.x(), point.y()};
}

/// The pieces of a polyline that are dashes; `dash` pixels of line and as much gap in turn.
std::vector<std::pair<cv::Point2d, cv::Point2d>> dashes(const cv::Point2d& a, const cv::Point2d& b, double dash,
                                                        double* walked) {
  std::vector<std::pair<cv::Point2d, cv::Point2d>> pieces;
  const cv::Point2d step = b - a;
  const double length = std::hypot(step.x, step.y);
  for (double at = 0; at < length;) {
    const double in_period = std::fmod(*walked + at, 2 * dash);
    const double end = std::min(length, at + (in_period < dash ? dash : 2 * dash) - in_period + 1e-6);
    if (in_period < dash) pieces.emplace_back(a + step * (at / length), a + step * (end / length));
    at = end;
  }
  *walked += length;
  return pieces;
}

}  // namespace

Canvas::Canvas(const cv::Mat& image) {
  if (image.channels() == 1) {
    cv::cvtColor(image, picture_, cv::COLOR_GRAY2BGR);
  } else {
    picture_ = image.clone();
  }
  const double size = std::hypot(picture_.cols, picture_.rows) / kSmallDiagonal;
  unit_ = std::max(1.0, size);
  text_scale_ = kSmallTextScale * std::max(0.8, size);
  text_thickness_ = std::max(1, static_cast<int>(std::lround(size)));
  text_bottom_ = 4 * unit_;
}

void Canvas::line(const std::vector<Eigen::Vector2d>& points, const cv::Scalar& color, double weight, LineStyle style) {
  const int thickness = std::max(1, static_cast<int>(std::lround(weight * unit_)));
  const int rim = 2 * std::max(1, static_cast<int>(std::lround(unit_ / 2)));
  // A dark rim below the line keeps it visible on a background of its own colour.
  for (const bool below : {true, false}) {
    double walked = 0;
    for (std::size_t i = 1; i < points.size(); ++i) {
      if (!drawable(points[i - 1]) || !drawable(points[i])) continue;
      const cv::Point2d a = to_cv(points[i - 1]);
      const cv::Point2d b = to_cv(points[i]);
      if (style == LineStyle::kSolid) {
        stroke(a, b, below ? kBlack : color, below ? thickness + rim : thickness);
        continue;
      }
      for (const auto& [from, to] : dashes(a, b, std::max(6.0, 4 * unit_), &walked)) {
        stroke(from, to, below ? kBlack : color, below ? thickness + rim : thickness);
      }
    }
  }
}

void Canvas::stroke(const cv::Point2d& a, const cv::Point2d& b, const cv::Scalar& color, int thickness) {
  constexpr int kFractionBits = 4;
  const auto fixed = [](double value) { return static_cast<int>(std::lround(value * (1 << kFractionBits))); };
  cv::line(picture_, {fixed(a.x), fixed(a.y)}, {fixed(b.x), fixed(b.y)}, color, thickness, cv::LINE_AA, kFractionBits);
}

void Canvas::cross(const Eigen::Vector2d& point, const cv::Scalar& color) {
  const double arm = 6 * unit_;
  line({point - Eigen::Vector2d(arm, 0), point + Eigen::Vector2d(arm, 0)}, color, 1, LineStyle::kSolid);
  line({point - Eigen::Vector2d(0, arm), point + Eigen::Vector2d(0, arm)}, color, 1, LineStyle::kSolid);
}

void Canvas::dot(const Eigen::Vector2d& point, const cv::Scalar& color) {
  if (!drawable(point)) return;
  const cv::Point pixel(static_cast<int>(std::lround(point.x())), static_cast<int>(std::lround(point.y())));
  if (!cv::Rect(0, 0, picture_.cols, picture_.rows).contains(pixel)) return;
  for (int channel = 0; channel < 3; ++channel) {
    picture_.at<cv::Vec3b>(pixel)[channel] = cv::saturate_cast<unsigned char>(color[channel]);
  }
}

void Canvas::text(const std::string& words, const cv::Scalar& color) {
  std::istringstream stream(words);
  std::string line;
  for (std::string word; stream >> word;) {
    std::string longer = line;
    if (!line.empty()) longer += ' ';
    longer += word;
    if (!line.empty() && text_width(longer) > picture_.cols - 8 * unit_) {
      text_line(line, color);
      line = "  " + word;
    } else {
      line = longer;
    }
  }
  if (!line.empty()) text_line(line, color);
}

void Canvas::text_line(const std::string& words, const cv::Scalar& color) {
  text_bottom_ += 38 * text_scale_;
  const cv::Point start(static_cast<int>(4 * unit_), static_cast<int>(text_bottom_ - 8 * text_scale_));
  cv::putText(picture_, words, start, cv::FONT_HERSHEY_SIMPLEX, text_scale_, kBlack, 3 * text_thickness_, cv::LINE_AA);
  cv::putText(picture_, words, start, cv::FONT_HERSHEY_SIMPLEX, text_scale_, color, text_thickness_, cv::LINE_AA);
}

int Canvas::text_width(const std::string& words) const {
  return cv::getTextSize(words, cv::FONT_HERSHEY_SIMPLEX, text_scale_, text_thickness_, nullptr).width;
}

}  // namespace cylpose
