#include "chart.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace cylpose::bench {
namespace {

constexpr int kLeft = 78;
constexpr int kRight = 16;
constexpr int kTop = 34;
constexpr int kBottom = 48;
constexpr double kTextScale = 0.42;

// B G R, after Okabe and Ito.
const std::array<cv::Scalar, 7> kPalette{
    {{178, 114, 0}, {0, 94, 213}, {60, 60, 60}, {115, 158, 0}, {0, 159, 230}, {167, 121, 204}, {233, 180, 86}}};
const cv::Scalar kInk = cv::Scalar::all(40);
const cv::Scalar kGrid = cv::Scalar::all(225);

// Where a value lies between the ends of an axis, 0..1.
double share(const Axis& axis, double value) {
  const double part = axis.logarithmic ? std::log(std::max(value, 1e-300) / axis.low) / std::log(axis.high / axis.low)
                                       : (value - axis.low) / (axis.high - axis.low);
  return std::clamp(part, 0.0, 1.0);
}

std::vector<double> ticks(const Axis& axis) {
  std::vector<double> places;
  if (axis.logarithmic) {
    for (double decade = std::pow(10, std::floor(std::log10(axis.low))); decade <= axis.high; decade *= 10) {
      for (const double step : {1, 2, 5}) {
        const double place = decade * step;
        const bool crowded = axis.high / axis.low > 300 && step > 1;
        if (!crowded && place >= axis.low * 0.999 && place <= axis.high * 1.001) places.push_back(place);
      }
    }
    return places;
  }
  const double raw = (axis.high - axis.low) / 6;
  const double decade = std::pow(10, std::floor(std::log10(raw)));
  const double step = raw / decade < 2 ? decade * 2 : (raw / decade < 5 ? decade * 5 : decade * 10);
  for (double place = std::ceil(axis.low / step) * step; place <= axis.high + step * 1e-6; place += step) {
    places.push_back(std::abs(place) < step * 1e-6 ? 0 : place);
  }
  return places;
}

class Painter {
 public:
  Painter(cv::Mat picture, const Chart& chart) : picture_(std::move(picture)), chart_(chart) {}

  void paint() {
    grid();
    for (const Series& series : chart_.series) {
      switch (series.mark) {
        case Mark::kDots:
          for (const cv::Point2d& point : series.points) {
            cv::circle(picture_, place(point), 3, color(series), cv::FILLED, cv::LINE_AA);
          }
          break;
        case Mark::kLine:
        case Mark::kDashes:
          line(series);
          break;
        case Mark::kBars:
          bars(series);
          break;
      }
    }
    legend();
  }

 private:
  [[nodiscard]] cv::Point place(const cv::Point2d& point) const {
    const double width = picture_.cols - kLeft - kRight;
    const double height = picture_.rows - kTop - kBottom;
    return {kLeft + static_cast<int>(std::lround(share(chart_.x, point.x) * width)),
            picture_.rows - kBottom - static_cast<int>(std::lround(share(chart_.y, point.y) * height))};
  }

  static const cv::Scalar& color(const Series& series) { return kPalette[series.color % kPalette.size()]; }

  void grid() {
    const int bottom = picture_.rows - kBottom;
    if (chart_.x.categories.empty()) {
      for (const double tick : ticks(chart_.x)) {
        const int x = place({tick, chart_.y.low}).x;
        cv::line(picture_, {x, kTop}, {x, bottom}, kGrid);
        text(fmt::format("{:g}", tick), {x - 8, bottom + 16});
      }
    }
    for (std::size_t i = 0; i < chart_.x.categories.size(); ++i) {
      const std::string& words = chart_.x.categories[i];
      const int width = cv::getTextSize(words, cv::FONT_HERSHEY_SIMPLEX, kTextScale, 1, nullptr).width;
      // In two lines in turn, as neighbours may be long.
      text(words, {place({static_cast<double>(i) + 0.5, 0}).x - width / 2, bottom + (i % 2 == 0 ? 15 : 29)});
    }
    for (const double tick : ticks(chart_.y)) {
      const int y = place({chart_.x.low, tick}).y;
      cv::line(picture_, {kLeft, y}, {picture_.cols - kRight, y}, kGrid);
      text(fmt::format("{:g}", tick), {30, y + 4});
    }
    cv::rectangle(picture_, cv::Rect(cv::Point(kLeft, kTop), cv::Point(picture_.cols - kRight, bottom)), kInk);
    text(chart_.title, {kLeft, 22});
    const int width = cv::getTextSize(chart_.x.label, cv::FONT_HERSHEY_SIMPLEX, kTextScale, 1, nullptr).width;
    text(chart_.x.label, {picture_.cols - kRight - width, picture_.rows - 6});
    text(chart_.y.label, {4, kTop - 4});
  }

  void line(const Series& series) {
    for (std::size_t i = 1; i < series.points.size(); ++i) {
      const cv::Point from = place(series.points[i - 1]);
      const cv::Point to = place(series.points[i]);
      if (series.mark == Mark::kLine) {
        cv::line(picture_, from, to, color(series), 2, cv::LINE_AA);
        continue;
      }
      constexpr double kDash = 6;
      const double length = cv::norm(to - from);
      for (double at = 0; at < length; at += 2 * kDash) {
        const cv::Point2d step = cv::Point2d(to - from) / length;
        cv::line(picture_, from + cv::Point(step * at), from + cv::Point(step * std::min(length, at + kDash)),
                 color(series), 1, cv::LINE_AA);
      }
    }
  }

  // Bars from zero, as wide as their distance leaves room for.
  void bars(const Series& series) {
    if (series.points.size() < 2) return;
    const double half = 0.4 * (series.points[1].x - series.points[0].x);
    for (const cv::Point2d& point : series.points) {
      const cv::Point corner = place({point.x - half, point.y});
      const cv::Point opposite = place({point.x + half, chart_.y.logarithmic ? chart_.y.low : 0});
      cv::rectangle(picture_, corner, opposite, color(series), cv::FILLED);
    }
  }

  void legend() {
    int y = kTop + 16;
    for (const Series& series : chart_.series) {
      if (series.name.empty()) continue;
      const int width = cv::getTextSize(series.name, cv::FONT_HERSHEY_SIMPLEX, kTextScale, 1, nullptr).width;
      const int left = picture_.cols - kRight - 34 - width;
      cv::rectangle(picture_, {left, y - 9}, {left + 18, y - 1}, color(series),
                    series.mark == Mark::kDashes ? 1 : cv::FILLED);
      text(series.name, {left + 24, y});
      y += 17;
    }
  }

  void text(const std::string& words, const cv::Point& baseline) {
    cv::putText(picture_, words, baseline, cv::FONT_HERSHEY_SIMPLEX, kTextScale, kInk, 1, cv::LINE_AA);
  }

  cv::Mat picture_;
  const Chart& chart_;
};

}  // namespace

cv::Mat drawn(const std::vector<Chart>& charts, int columns, cv::Size each) {
  const int rows = (static_cast<int>(charts.size()) + columns - 1) / columns;
  cv::Mat picture(rows * each.height, columns * each.width, CV_8UC3, cv::Scalar::all(255));
  for (std::size_t i = 0; i < charts.size(); ++i) {
    const int index = static_cast<int>(i);
    const cv::Rect place((index % columns) * each.width, (index / columns) * each.height, each.width, each.height);
    Painter(picture(place), charts[i]).paint();
  }
  return picture;
}

}  // namespace cylpose::bench
