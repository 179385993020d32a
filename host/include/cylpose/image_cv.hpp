// cv::Mat as ImageView, without a copy.
#pragma once

#include <cylpose/error.hpp>
#include <cylpose/image.hpp>
#include <opencv2/core/mat.hpp>

namespace cylpose {

/// Views `image` (8-bit, one or three channels; three are taken as BGR, OpenCV's order). The Mat must outlive the view.
/// Throws Error(kInput) for any other depth or number of channels.
inline ImageView view_of(const cv::Mat& image, PixelFormat color_order = PixelFormat::kBgr8) {
  if (image.type() != CV_8UC3 && image.type() != CV_8UC1) {
    throw Error(ErrorKind::kInput, "image has " + std::to_string(image.channels()) + " channels of OpenCV depth " +
                                       std::to_string(image.depth()) +
                                       "; cylpose takes 8-bit images of 1 or 3 channels");
  }
  return {image.data, image.cols, image.rows, static_cast<std::ptrdiff_t>(image.step),
          image.channels() == 1 ? PixelFormat::kGray8 : color_order};
}

/// Views `image` as a cv::Mat header on the same pixels. The Mat must not be written to.
inline cv::Mat mat_of(const ImageView& image) {
  return {image.height, image.width, image.format == PixelFormat::kGray8 ? CV_8UC1 : CV_8UC3,
          const_cast<std::uint8_t*>(image.data), static_cast<std::size_t>(image.stride)};
}

}  // namespace cylpose
