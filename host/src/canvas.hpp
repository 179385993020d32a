// Drawing on a picture so that it stays legible from thumbnails to 4K and on any background.
#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

namespace cylpose {

enum class LineStyle { kSolid, kDashed };

class Canvas {
 public:
  /// A BGR copy of `image` (grey or BGR) to draw on.
  explicit Canvas(const cv::Mat& image);

  /// Joins points in pixels (fractions count). `weight` is in widths of a thin line at this size of picture. Points
  /// that are not finite or far outside interrupt the line.
  void line(const std::vector<Eigen::Vector2d>& points, const cv::Scalar& color, double weight, LineStyle style);

  /// A cross at a place in pixels.
  void cross(const Eigen::Vector2d& point, const cv::Scalar& color);

  /// One pixel; nothing outside the picture.
  void dot(const Eigen::Vector2d& point, const cv::Scalar& color);

  /// Adds a line of text at the top left, below those before, broken where it would leave the picture.
  void text(const std::string& words, const cv::Scalar& color);

  [[nodiscard]] const cv::Mat& picture() const { return picture_; }

 private:
  void stroke(const cv::Point2d& a, const cv::Point2d& b, const cv::Scalar& color, int thickness);
  void text_line(const std::string& words, const cv::Scalar& color);
  [[nodiscard]] int text_width(const std::string& words) const;

  cv::Mat picture_;
  double unit_;         ///< width of a thin line, pixels
  double text_scale_;   ///< OpenCV's font scale
  int text_thickness_;  ///< pixels
  double text_bottom_;  ///< rows used by text so far
};

}  // namespace cylpose
