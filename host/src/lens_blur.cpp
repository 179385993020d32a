#include "lens_blur.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <opencv2/core.hpp>
#include <vector>

// Plain loops instead of OpenCV's filters: those differ in the last bit from one processor to the next, and with them
// the rounded bytes.

namespace cylpose {
namespace {

constexpr std::size_t kCells = MixedPixel::kCells;

// How light that falls evenly into one cell of a pixel is shared among the pixels around, along one direction.
class Spread {
 public:
  // No blur in this direction: a cell's light stays in its pixel.
  Spread() : of_pixel_{1} {
    for (auto& weights : of_cell_) weights = {1};
  }

  Spread(BlurKernel kernel, double sigma_px) {
    const bool box = kernel != BlurKernel::kGaussian;
    const double half_width = box ? std::numbers::sqrt3 * sigma_px : 4 * sigma_px;
    // Of the kernel, twice: differences of the second are means over a cell of what falls on one side of a place.
    const auto second_integral = [&](double place) {
      if (box) {
        const double inside = std::clamp(place + half_width, 0.0, 2 * half_width);
        return inside * inside / (4 * half_width) + std::max(0.0, place - half_width);
      }
      const double z = place / sigma_px;
      return place * 0.5 * std::erfc(-z / std::numbers::sqrt2) +
             sigma_px * std::exp(-z * z / 2) / std::sqrt(2 * std::numbers::pi);
    };
    reach_ = static_cast<int>(std::ceil(half_width));
    std::vector<double> mean(width(), 0.0);
    for (std::size_t cell = 0; cell < kCells; ++cell) {
      const double from = static_cast<double>(cell) / kCells - 0.5;
      const double to = static_cast<double>(cell + 1) / kCells - 0.5;
      const auto share_left_of = [&](double place) {
        return static_cast<double>(kCells) * (second_integral(place - from) - second_integral(place - to));
      };
      const double first = share_left_of(-reach_ - 0.5);
      const double all = share_left_of(reach_ + 0.5) - first;
      double before = first;
      for (int d = -reach_; d <= reach_; ++d) {
        const double up_to = share_left_of(d + 0.5);
        const double share = (up_to - before) / all;
        of_cell_[cell].push_back(static_cast<float>(share));
        mean[index(d)] += share / kCells;
        before = up_to;
      }
    }
    for (int d = 0; d <= reach_; ++d) of_pixel_.push_back(static_cast<float>(mean[index(d)]));
  }

  [[nodiscard]] int reach() const { return reach_; }
  [[nodiscard]] std::size_t width() const { return index(reach_) + 1; }

  // What goes from a cell to the pixel `d` away, -reach..reach.
  [[nodiscard]] float of_cell(std::size_t cell, int d) const { return of_cell_[cell][index(d)]; }

  // The same of an evenly lit pixel, by distance: as much goes to either side.
  [[nodiscard]] const std::vector<float>& of_pixel() const { return of_pixel_; }

 private:
  [[nodiscard]] std::size_t index(int d) const {
    const int from_first = d + reach_;
    return static_cast<std::size_t>(from_first);
  }

  int reach_ = 0;
  std::array<std::vector<float>, kCells> of_cell_;
  std::vector<float> of_pixel_;
};

// Mirrored at the border's outer edge (c b a | a b c), which loses no light.
int mirrored(int i, int size) {
  const int period = 2 * size;
  const int wrapped = ((i % period) + period) % period;
  return wrapped < size ? wrapped : period - 1 - wrapped;
}

cv::Mat blurred_rows(const cv::Mat& light, const std::vector<float>& kernel) {
  const int radius = static_cast<int>(kernel.size()) - 1;
  const auto channels = static_cast<std::size_t>(light.channels());
  cv::Mat out(light.size(), light.type());
  std::vector<float> padded((static_cast<std::size_t>(light.cols) + 2 * static_cast<std::size_t>(radius)) * channels);
  for (int y = 0; y < light.rows; ++y) {
    const float* in_row = light.ptr<float>(y);
    for (int x = -radius; x < light.cols + radius; ++x) {
      std::copy_n(in_row + static_cast<std::size_t>(mirrored(x, light.cols)) * channels, channels,
                  padded.begin() + (x + radius) * static_cast<std::ptrdiff_t>(channels));
    }
    float* out_row = out.ptr<float>(y);
    const std::size_t count = static_cast<std::size_t>(light.cols) * channels;
    const float* middle = padded.data() + static_cast<std::size_t>(radius) * channels;
    for (std::size_t i = 0; i < count; ++i) out_row[i] = kernel[0] * middle[i];
    for (std::size_t k = 1; k < kernel.size(); ++k) {
      const float* left = middle - k * channels;
      const float* right = middle + k * channels;
      for (std::size_t i = 0; i < count; ++i) out_row[i] += kernel[k] * (left[i] + right[i]);
    }
  }
  return out;
}

cv::Mat blurred_columns(const cv::Mat& light, const std::vector<float>& kernel) {
  cv::Mat out(light.size(), light.type());
  const std::size_t count = static_cast<std::size_t>(light.cols) * static_cast<std::size_t>(light.channels());
  for (int y = 0; y < light.rows; ++y) {
    float* out_row = out.ptr<float>(y);
    const float* middle = light.ptr<float>(y);
    for (std::size_t i = 0; i < count; ++i) out_row[i] = kernel[0] * middle[i];
    for (int k = 1; k < static_cast<int>(kernel.size()); ++k) {
      const float weight = kernel[static_cast<std::size_t>(k)];
      const float* above = light.ptr<float>(mirrored(y - k, light.rows));
      const float* below = light.ptr<float>(mirrored(y + k, light.rows));
      for (std::size_t i = 0; i < count; ++i) out_row[i] += weight * (above[i] + below[i]);
    }
  }
  return out;
}

// What an evenly lit pixel of the same light would not have sent where it goes.
void add_unevenness(const MixedPixel& pixel, const Spread& across, const Spread& down, cv::Mat* light) {
  const std::size_t width = across.width();
  std::array<std::vector<cv::Vec3f>, kCells> rows_of_cells;
  for (std::size_t row = 0; row < kCells; ++row) {
    rows_of_cells[row].assign(width, cv::Vec3f());
    for (std::size_t column = 0; column < kCells; ++column) {
      for (std::size_t i = 0; i < width; ++i) {
        rows_of_cells[row][i] +=
            across.of_cell(column, static_cast<int>(i) - across.reach()) * pixel.excess[row][column];
      }
    }
  }
  for (int dy = -down.reach(); dy <= down.reach(); ++dy) {
    auto* out = light->ptr<cv::Vec3f>(mirrored(pixel.y + dy, light->rows));
    for (std::size_t i = 0; i < width; ++i) {
      cv::Vec3f& sum = out[mirrored(pixel.x + static_cast<int>(i) - across.reach(), light->cols)];
      for (std::size_t row = 0; row < kCells; ++row) sum += down.of_cell(row, dy) * rows_of_cells[row][i];
    }
  }
}

}  // namespace

cv::Mat blurred(const SceneLight& light, BlurKernel kernel, double sigma_px) {
  const Spread across(kernel, sigma_px);
  const Spread down = kernel == BlurKernel::kMotion ? Spread() : across;
  cv::Mat result = blurred_columns(blurred_rows(light.pixels, across.of_pixel()), down.of_pixel());
  for (const MixedPixel& pixel : light.mixed) add_unevenness(pixel, across, down, &result);
  return result;
}

}  // namespace cylpose
