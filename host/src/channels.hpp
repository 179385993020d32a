// Where red, green and blue lie within a pixel.
#pragma once

#include <cylpose/image.hpp>

namespace cylpose {

struct Channels {
  int red;
  int green;
  int blue;
  int step;  ///< bytes from one pixel to the next
};

/// Of a grey image all three are the one code there is.
constexpr Channels channels_of(PixelFormat format) {
  switch (format) {
    case PixelFormat::kBgr8:
      return {2, 1, 0, 3};
    case PixelFormat::kRgb8:
      return {0, 1, 2, 3};
    case PixelFormat::kGray8:
      break;
  }
  return {0, 0, 0, 1};
}

}  // namespace cylpose
