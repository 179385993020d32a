#include "stage_picture.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <string>

#include "figures.hpp"

namespace cylpose::bench {
namespace {

constexpr int kMargin = 30;
constexpr int kLegendHeight = 70;
constexpr int kPanelWidth = 800;
constexpr int kNameWidth = 80;    // backends, left of the bars
constexpr int kNumberWidth = 90;  // milliseconds, right of the bars
constexpr int kBarHeight = 18;
constexpr int kBarStep = 22;
constexpr int kTitleHeight = 26;
constexpr int kGroupGap = 12;

// B G R.
struct Color {
  std::uint8_t blue, green, red;
};

constexpr Color kInk{40, 40, 40};
constexpr Color kRest{205, 205, 205};

// Neighbours can be told apart with any kind of colour vision (after Okabe and Ito); then darker ones of the same.
constexpr std::array<Color, 12> kPalette{{{178, 114, 0},
                                          {0, 159, 230},
                                          {115, 158, 0},
                                          {66, 228, 240},
                                          {167, 121, 204},
                                          {233, 180, 86},
                                          {0, 94, 213},
                                          {110, 70, 0},
                                          {70, 100, 0},
                                          {0, 100, 150},
                                          {110, 75, 130},
                                          {90, 90, 90}}};

cv::Scalar scalar(const Color& color) {
  return {static_cast<double>(color.blue), static_cast<double>(color.green), static_cast<double>(color.red)};
}

class Chart {
 public:
  Chart(cv::Size size, std::vector<std::string> stages)
      : picture_(size, CV_8UC3, cv::Scalar::all(255)), stages_(std::move(stages)) {}

  void legend() {
    cv::Point at(kMargin, kMargin);
    for (std::size_t i = 0; i <= stages_.size(); ++i) {
      const std::string name = i < stages_.size() ? stages_[i] : "between stages";
      const int width = 40 + text_width(name);
      if (at.x + width > picture_.cols - kMargin) at = {kMargin, at.y + kTitleHeight};
      box(at.x, at.y - 12, 16, 16, i < stages_.size() ? color(i) : kRest);
      text(name, at + cv::Point(22, 2));
      at.x += width;
    }
  }

  void panel(const CaseGrid& grid, int left) {
    int top = kMargin + kLegendHeight;
    for (const CaseRow& row : grid.rows) {
      text(fmt::format("{} {} {}", grid.kind, row.scene, row.size), {left, top + 16});
      top += kTitleHeight;
      const double longest = longest_of(row);
      for (std::size_t i = 0; i < grid.backends.size(); ++i) {
        if (row.by_backend[i] != nullptr) bar(*row.by_backend[i], grid.backends[i], longest, {left, top});
        top += kBarStep;
      }
      top += kGroupGap;
    }
  }

  static int panel_height(const CaseGrid& grid) {
    return static_cast<int>(grid.rows.size()) *
           (kTitleHeight + kGroupGap + kBarStep * static_cast<int>(grid.backends.size()));
  }

  [[nodiscard]] const cv::Mat& picture() const { return picture_; }

 private:
  struct Bar {
    std::vector<Stage> stages;
    double staged = 0;  ///< sum of the stages
    double total = 0;   ///< median of the frame's time
  };

  static Bar bar_of(const Measured& cell) {
    Bar bar{stages_of(cell), 0, median(cell.milliseconds)};
    for (const Stage& stage : bar.stages) bar.staged += stage.milliseconds;
    return bar;
  }

  static double longest_of(const CaseRow& row) {
    double longest = 0;
    for (const Measured* cell : row.by_backend) {
      if (cell == nullptr) continue;
      const Bar bar = bar_of(*cell);
      longest = std::max({longest, bar.staged, bar.total});
    }
    return longest;
  }

  void bar(const Measured& cell, const std::string& backend, double longest, const cv::Point& at) {
    const Bar bar = bar_of(cell);
    const int left = at.x + kNameWidth;
    const double pixels_per_ms = (kPanelWidth - kNameWidth - kNumberWidth) / longest;
    const auto place = [&](double ms) { return left + static_cast<int>(std::lround(ms * pixels_per_ms)); };
    text(backend, at + cv::Point(0, 14));
    box(left, at.y, place(bar.total) - left, kBarHeight, kRest);
    double from = 0;
    for (const Stage& stage : bar.stages) {
      const double to = from + stage.milliseconds;
      box(place(from), at.y, place(to) - place(from), kBarHeight, color_of(stage.name));
      from = to;
    }
    text(fmt::format("{:.3f} ms", bar.total), {place(std::max(bar.total, bar.staged)) + 6, at.y + 14});
  }

  [[nodiscard]] Color color_of(const std::string& stage) const {
    return color(static_cast<std::size_t>(std::ranges::find(stages_, stage) - stages_.begin()));
  }
  static Color color(std::size_t stage) { return kPalette[stage % kPalette.size()]; }

  void box(int x, int y, int width, int height, const Color& fill) {
    if (width > 0) cv::rectangle(picture_, cv::Rect(x, y, width, height), scalar(fill), cv::FILLED);
  }

  void text(const std::string& words, const cv::Point& baseline) {
    cv::putText(picture_, words, baseline, cv::FONT_HERSHEY_SIMPLEX, kTextScale, scalar(kInk), 1, cv::LINE_AA);
  }

  static int text_width(const std::string& words) {
    return cv::getTextSize(words, cv::FONT_HERSHEY_SIMPLEX, kTextScale, 1, nullptr).width;
  }

  static constexpr double kTextScale = 0.45;

  cv::Mat picture_;
  std::vector<std::string> stages_;
};

}  // namespace

cv::Mat stage_picture(const BenchRun& run) {
  std::vector<CaseGrid> grids;
  int height = 0;
  for (const char* kind : {"detect", "estimate"}) {
    CaseGrid grid = grid_of(run, kind);
    if (grid.rows.empty()) continue;
    height = std::max(height, Chart::panel_height(grid));
    grids.push_back(std::move(grid));
  }
  const int panels = std::max(1, static_cast<int>(grids.size()));
  Chart chart({kMargin + panels * (kPanelWidth + kMargin), height + kLegendHeight + 2 * kMargin}, stage_names(grids));
  chart.legend();
  for (std::size_t i = 0; i < grids.size(); ++i) {
    chart.panel(grids[i], kMargin + static_cast<int>(i) * (kPanelWidth + kMargin));
  }
  return chart.picture();
}

}  // namespace cylpose::bench
