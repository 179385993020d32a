// Simple charts: axes, dots, lines, bars. For plots in reports.
#pragma once

#include <array>
#include <opencv2/core/mat.hpp>
#include <string>
#include <vector>

namespace cylpose::bench {

struct Axis {
  std::string label;
  double low;
  double high;
  bool logarithmic = false;
  std::vector<std::string> categories = {};  ///< at 0.5, 1.5, ... in place of numbers
};

enum class Mark { kDots, kLine, kDashes, kBars };

struct Series {
  std::string name;  ///< in the legend; empty: not there
  Mark mark;
  std::size_t color;                ///< index into a palette of seven; neighbours differ for any kind of colour vision
  std::vector<cv::Point2d> points;  ///< those beyond the axes are drawn at their ends
};

struct Chart {
  std::string title;
  Axis x;
  Axis y;
  std::vector<Series> series;
};

/// All charts on one picture, `columns` in a row, each of the given size: CV_8UC3.
[[nodiscard]] cv::Mat drawn(const std::vector<Chart>& charts, int columns, cv::Size each = {760, 480});

}  // namespace cylpose::bench
