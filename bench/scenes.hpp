// The pictures that the benchmarks work on.
#pragma once

#include <array>
#include <cylpose/camera.hpp>
#include <cylpose/image.hpp>
#include <cylpose/image_cv.hpp>
#include <cylpose/part.hpp>
#include <opencv2/core/mat.hpp>
#include <string>
#include <vector>

namespace cylpose::bench {

struct FrameSize {
  int width;
  int height;
  friend bool operator<(const FrameSize& a, const FrameSize& b) { return a.width < b.width; }
};

inline constexpr std::array<FrameSize, 4> kFrameSizes{{{640, 400}, {1280, 720}, {1920, 1080}, {3840, 2160}}};

[[nodiscard]] std::string to_string(const FrameSize& size);  ///< "1280x720"

struct BenchScene {
  cv::Mat picture;  ///< shares its pixels with the other scenes of its size
  CameraModel camera;
  std::vector<PartModel> parts;
  Roi search;

  [[nodiscard]] ImageView image() const { return view_of(picture); }
};

/// A frame of the scenario `series4`, its camera scaled to `size` so that the part covers the same share of the
/// picture's height or width; the whole frame is searched. Rendered at the first call for a size. Not for several
/// threads.
[[nodiscard]] BenchScene full_scene(const FrameSize& size);

/// The same picture, searched only where the part's pose in the frame before says (SearchRegion).
[[nodiscard]] BenchScene roi_scene(const FrameSize& size);

/// Some frames of the scenario that follow each other, 1280 x 720.
struct Recording {
  std::vector<cv::Mat> pictures;
  CameraModel camera;
  std::vector<PartModel> parts;
};

/// Rendered at the first call.
[[nodiscard]] const Recording& recording();

/// 64 x 64 pixels of an evenly grey frame: nothing to find, so what it takes is the way there and back.
[[nodiscard]] BenchScene empty_scene();

/// A red rectangle: quick to draw, with work for every stage.
[[nodiscard]] BenchScene rectangle_scene();

}  // namespace cylpose::bench
