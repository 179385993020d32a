// Algorithm 5.3: from the colour image to the edges of the part's mask.
#include <algorithm>
#include <array>
#include <cmath>
#include <cylpose/image_cv.hpp>
#include <cylpose/thesis.hpp>
#include <opencv2/imgproc.hpp>

namespace cylpose {
namespace {

// Canny's Sobel and non-maximum suppression look two pixels around.
constexpr int kCannyReach = 2;
// Steps of the binary mask have gradients of 255 and more, everything else has 0: any thresholds between will do.
constexpr double kCannyLow = 100;
constexpr double kCannyHigh = 200;

cv::Mat mat_over(Mask* mask) {
  return {mask->roi.height, mask->roi.width, CV_8UC1, mask->pixels.data()};
}

// Read only: OpenCV has no header for constant pixels.
cv::Mat mat_over(const Mask& mask) {
  return {mask.roi.height, mask.roi.width, CV_8UC1, const_cast<std::uint8_t*>(mask.pixels.data())};
}

cv::Rect rect_of(const Roi& roi) {
  return {roi.x, roi.y, roi.width, roi.height};
}

Mask empty_mask(const Roi& roi) {
  return {roi, std::vector<std::uint8_t>(static_cast<std::size_t>(roi.width) * static_cast<std::size_t>(roi.height))};
}

// OpenCV's hue is round(degrees / 2) with 180 written as 0, so the range has up to two pieces.
struct HueBand {
  int lo, hi;  // empty where lo > hi
};

std::array<HueBand, 2> hue_bands(const PartModel& part) {
  constexpr int kTop = 179;
  const int lo = static_cast<int>(std::lround(part.hue_lo_deg / 2));
  const int hi = static_cast<int>(std::lround(part.hue_hi_deg / 2));
  if (part.hue_lo_deg > part.hue_hi_deg) return {{{lo, kTop}, {0, hi}}};
  return {{{lo, std::min(hi, kTop)}, {0, hi > kTop ? 0 : -1}}};
}

}  // namespace

Mask thesis_gate(const ImageView& image, const Roi& search, const PartModel& part) {
  Mask mask = empty_mask(search);
  cv::Mat result = mat_over(&mask);
  const cv::Mat pixels = mat_of(image)(rect_of(search));
  const double min_value = std::ceil(part.min_value * 255);
  if (image.format == PixelFormat::kGray8) {
    cv::inRange(pixels, min_value, 255, result);
    return mask;
  }
  cv::Mat hsv;
  cv::cvtColor(pixels, hsv, image.format == PixelFormat::kBgr8 ? cv::COLOR_BGR2HSV : cv::COLOR_RGB2HSV);
  // Greys and black have no hue, whatever number stands in their place; only the whole circle takes them in.
  const double least = part.hue_hi_deg - part.hue_lo_deg >= 360 ? 0 : 1;
  const double min_saturation = std::max(least, std::ceil(part.min_saturation * 255));
  cv::Mat piece;
  for (const HueBand& band : hue_bands(part)) {
    if (band.lo > band.hi) continue;
    cv::inRange(hsv, cv::Scalar(band.lo, min_saturation, std::max(least, min_value)), cv::Scalar(band.hi, 255, 255),
                piece);
    cv::bitwise_or(result, piece, result);
  }
  return mask;
}

void thesis_morphology(Mask* mask) {
  cv::Mat pixels = mat_over(mask);
  cv::erode(pixels, pixels, cv::noArray());
  cv::dilate(pixels, pixels, cv::noArray());
}

RegionStatistics thesis_statistics(const Mask& mask) {
  const cv::Mat pixels = mat_over(mask);
  const cv::Moments local = cv::moments(pixels, true);
  RegionStatistics region;
  region.m00 = std::llround(local.m00);
  if (region.m00 == 0) return region;
  // From the mask's coordinates to the frame's: all of these are integers, which doubles hold exactly.
  const std::int64_t x0 = mask.roi.x;
  const std::int64_t y0 = mask.roi.y;
  const std::int64_t m10 = std::llround(local.m10);
  const std::int64_t m01 = std::llround(local.m01);
  region.m10 = m10 + x0 * region.m00;
  region.m01 = m01 + y0 * region.m00;
  region.m20 = std::llround(local.m20) + 2 * x0 * m10 + x0 * x0 * region.m00;
  region.m11 = std::llround(local.m11) + x0 * m01 + y0 * m10 + x0 * y0 * region.m00;
  region.m02 = std::llround(local.m02) + 2 * y0 * m01 + y0 * y0 * region.m00;
  const cv::Rect box = cv::boundingRect(pixels);
  region.box = {box.x + mask.roi.x, box.y + mask.roi.y, box.width, box.height};
  return region;
}

Mask thesis_canny(const Mask& mask, const Roi& box) {
  const Roi crop = intersection(
      {box.x - kCannyReach, box.y - kCannyReach, box.width + 2 * kCannyReach, box.height + 2 * kCannyReach}, mask.roi);
  Mask edges = empty_mask(crop);
  if (crop.empty()) return edges;
  cv::Mat result = mat_over(&edges);
  const cv::Rect inside(crop.x - mask.roi.x, crop.y - mask.roi.y, crop.width, crop.height);
  cv::Canny(mat_over(mask)(inside), result, kCannyLow, kCannyHigh);
  return edges;
}

}  // namespace cylpose
