// The stages as OpenCV has them, on all threads OpenCV uses: the peer that the other backends are compared with. Its
// masks are not quite those of `serial`: an 8-bit hue has steps of 1.4 degrees, so less than 1.5 % of random colours
// fall on the other side of a border, and Canny itself keeps weak edges only where they touch strong ones.
#include <algorithm>
#include <array>
#include <cmath>
#include <cylpose/gate.hpp>
#include <cylpose/image_cv.hpp>
#include <cylpose/locate.hpp>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "builtin_backends.hpp"
#include "stage_clock.hpp"

namespace cylpose {
namespace {

cv::Rect rect_of(const Roi& roi) {
  return {roi.x, roi.y, roi.width, roi.height};
}

// Hue in 256 steps of the circle, both ends inside; `last` may lie beyond the circle's end.
struct HueSteps {
  int first;
  int last;
};

HueSteps hue_steps(const PartModel& part, const ColorGate& gate) {
  if (gate.any_hue != 0) return {0, 255};
  const auto step = [](double degrees) { return static_cast<int>(std::lround(degrees * 256 / 360)) % 256; };
  const int first = step(part.hue_lo_deg);
  const int last = step(part.hue_hi_deg);
  // Ends that fall on one step are a range of that step, or all but the whole circle.
  const bool wraps = last < first || (last == first && gate.wide != 0);
  return {first, last + (wraps ? 256 : 0)};
}

void gate_hsv(const cv::Mat& hsv, const PartModel& part, const ColorGate& gate, cv::Mat& mask) {
  const int saturation = std::max(gate.any_hue != 0 ? 0 : 1, static_cast<int>(std::lround(part.min_saturation * 255)));
  const auto [first, last] = hue_steps(part, gate);
  cv::inRange(hsv, cv::Scalar(first, saturation, gate.value), cv::Scalar(std::min(last, 255), 255, 255), mask);
  if (last > 255) {
    cv::Mat wrapped;
    cv::inRange(hsv, cv::Scalar(0, saturation, gate.value), cv::Scalar(last - 256, 255, 255), wrapped);
    mask |= wrapped;
  }
}

// From the region's own coordinates to the frame's.
RegionStatistics statistics_of(const cv::Mat& mask, const Roi& searched) {
  const cv::Rect box = cv::boundingRect(mask);
  if (box.empty()) return {};
  const cv::Moments m = cv::moments(mask, true);
  const auto exact = [](double value) { return static_cast<std::int64_t>(std::llround(value)); };
  const std::int64_t x = searched.x;
  const std::int64_t y = searched.y;
  RegionStatistics region;
  region.m00 = exact(m.m00);
  region.m10 = exact(m.m10) + x * region.m00;
  region.m01 = exact(m.m01) + y * region.m00;
  region.m20 = exact(m.m20) + 2 * x * exact(m.m10) + x * x * region.m00;
  region.m11 = exact(m.m11) + x * exact(m.m01) + y * exact(m.m10) + x * y * region.m00;
  region.m02 = exact(m.m02) + 2 * y * exact(m.m01) + y * y * region.m00;
  region.box = {searched.x + box.x, searched.y + box.y, box.width, box.height};
  return region;
}

// What response() of gate.hpp says, rounded instead of cut off.
cv::Mat response_of(const cv::Mat& image, const cv::Mat& hsv, const ColorGate& gate, PixelFormat format) {
  cv::Mat result;
  if (format == PixelFormat::kGray8) {
    result = image;
  } else if (gate.any_hue == 0) {
    // Channel by channel: several times as fast as cv::transform.
    std::array<cv::Mat, 3> channels;
    cv::split(image, channels.data());
    const std::size_t red = format == PixelFormat::kBgr8 ? 2 : 0;
    const std::size_t blue = 2 - red;
    cv::Mat wide_blue;
    channels[blue].convertTo(wide_blue, CV_16S);
    const auto combined = [&](int of_red, int of_blue) {
      cv::Mat red_green;
      cv::Mat sum;
      cv::addWeighted(channels[red], of_red / 64.0, channels[1], -(of_red + of_blue) / 64.0, 0, red_green, CV_16S);
      cv::addWeighted(red_green, 1, wide_blue, of_blue / 64.0, 0, sum);
      return sum;
    };
    const cv::Mat aside = cv::abs(combined(gate.aside_r, gate.aside_b));
    cv::subtract(combined(gate.response_r, gate.response_b), aside, result, cv::noArray(), CV_8U);
  } else {
    cv::extractChannel(hsv, result, 2);
    if (gate.saturation_256 != 0) {
      cv::Mat saturation;
      cv::extractChannel(hsv, saturation, 1);
      cv::multiply(result, saturation, result, 1 / 255.0);
    }
  }
  return result;
}

// Canny's edges in the band; `origin` is the top-left pixel of both images in the frame.
std::vector<EdgePixel> edges_of(const cv::Mat& response_image, const cv::Mat& band, const cv::Point& origin,
                                const DetectOptions& options) {
  cv::Mat dx;
  cv::Mat dy;
  cv::spatialGradient(response_image, dx, dy, 3, cv::BORDER_REPLICATE);
  constexpr int kSobelScale = 8;  // of a slope of one level per pixel
  cv::Mat canny;
  cv::Canny(dx, dy, canny, kSobelScale * options.edge_low, kSobelScale * options.edge_high, true);
  canny &= band;

  std::vector<cv::Point> points;
  cv::findNonZero(canny, points);
  const int strong = kSobelScale * kSobelScale * options.edge_high * options.edge_high;
  std::vector<EdgePixel> edges;
  edges.reserve(points.size());
  for (const cv::Point& point : points) {
    const std::int16_t gx = dx.at<std::int16_t>(point);
    const std::int16_t gy = dy.at<std::int16_t>(point);
    edges.push_back({static_cast<std::int16_t>(origin.x + point.x), static_cast<std::int16_t>(origin.y + point.y), gx,
                     gy, 0, gx * gx + gy * gy >= strong ? EdgeStrength::kStrong : EdgeStrength::kWeak});
  }
  return edges;
}

// Leaves of a part what lies in `rows`.
void keep_rows(const Rows& rows, const cv::Mat& mask, const Roi& searched, PartEdges& part) {
  const int end = std::min(rows.end, mask.rows);
  const int first = std::min(rows.first, end);
  if (first == 0 && end == mask.rows) return;
  part.region = statistics_of(mask.rowRange(first, end), {searched.x, searched.y + first, mask.cols, end - first});
  std::erase_if(part.edges,
                [&](const EdgePixel& edge) { return edge.y < searched.y + first || edge.y >= searched.y + end; });
}

Mask copied(const cv::Mat& mask, const Roi& searched) {
  return {searched, {mask.begin<std::uint8_t>(), mask.end<std::uint8_t>()}};
}

class OpencvBackend final : public Backend {
 public:
  [[nodiscard]] std::string_view name() const override { return "opencv"; }

  [[nodiscard]] EdgeField detect(const ImageView& image, const Roi& search, std::span<const PartModel> parts,
                                 const DetectOptions& options) override {
    EdgeField field;
    field.searched = usable_search(image, search, options);
    field.parts.resize(parts.size());
    if (field.searched.empty()) return field;
    std::vector<ColorGate> gates;
    gates.reserve(parts.size());
    for (const PartModel& part : parts) gates.push_back(make_gate(part));
    const cv::Mat pixels = mat_of(image)(rect_of(field.searched));
    const bool gray = image.format == PixelFormat::kGray8;

    StageClock clock;
    cv::Mat hsv;
    if (!gray) {
      const int to_hsv = image.format == PixelFormat::kBgr8 ? cv::COLOR_BGR2HSV_FULL : cv::COLOR_RGB2HSV_FULL;
      cv::cvtColor(pixels, hsv, to_hsv);
    }
    std::vector<cv::Mat> masks(parts.size());
    for (std::size_t i = 0; i < parts.size(); ++i) {
      if (gray) {
        cv::inRange(pixels, gates[i].value, 255, masks[i]);
      } else {
        gate_hsv(hsv, parts[i], gates[i], masks[i]);
      }
    }
    clock.lap("gate");

    for (cv::Mat& mask : masks) {
      cv::erode(mask, mask, {});
      cv::dilate(mask, mask, {});
    }
    clock.lap("morphology");

    for (std::size_t i = 0; i < parts.size(); ++i) {
      field.parts[i].region = statistics_of(masks[i], field.searched);
    }
    clock.lap("statistics");

    for (std::size_t i = 0; i < parts.size(); ++i) {
      PartEdges& part = field.parts[i];
      if (part.region.m00 == 0) continue;
      constexpr int kHalo = 4;  // band 2, suppression 1, Sobel 1
      const Roi& box = part.region.box;
      const Roi near =
          intersection({box.x - kHalo, box.y - kHalo, box.width + 2 * kHalo, box.height + 2 * kHalo}, field.searched);
      const cv::Rect local = rect_of({near.x - field.searched.x, near.y - field.searched.y, near.width, near.height});
      cv::Mat band;
      cv::Mat core;
      cv::dilate(masks[i](local), band, {}, {-1, -1}, 2);
      cv::erode(masks[i](local), core, {}, {-1, -1}, 2);
      band -= core;
      const cv::Mat response_image = response_of(pixels(local), gray ? cv::Mat() : hsv(local), gates[i], image.format);
      part.edges = edges_of(response_image, band, {near.x, near.y}, options);
      keep_rows(options.rows, masks[i], field.searched, part);
    }
    clock.lap("edges");

    for (std::size_t i = 0; options.locate && i < parts.size(); ++i) {
      locate_edges(image, field.searched, gates[i], options.transfer, field.parts[i].edges);
    }
    clock.lap("locate");

    if (options.with_mask) {
      for (std::size_t i = 0; i < parts.size(); ++i) field.parts[i].mask = copied(masks[i], field.searched);
    }
    field.times = clock.times();
    return field;
  }
};

}  // namespace

std::unique_ptr<Backend> make_opencv_backend() {
  return std::make_unique<OpencvBackend>();
}

}  // namespace cylpose
