// The picture that shows what was estimated.
#pragma once

#include <cylpose/camera.hpp>
#include <cylpose/part.hpp>
#include <cylpose/pose.hpp>
#include <opencv2/core/mat.hpp>
#include <span>
#include <string>

namespace cylpose {

/// A BGR copy of `image` (8-bit, grey or BGR) with, drawn at a scale that fits its size,
///  - the search region (grey, dashed),
///  - per part that has a pose: the two side lines as measured (magenta), the predicted cylinder (yellow; hidden rims
///    thin and dashed), the axis (cyan, dashed) and the centre (cyan cross), as curves where the lens bends them,
///  - per part: status, position, axis, their sigmas and rms, or the reason why there is no pose.
/// One estimate per part; throws Error(kInput) when their numbers differ.
[[nodiscard]] cv::Mat overlay(const cv::Mat& image, const CameraModel& camera, std::span<const PartModel> parts,
                              const FrameEstimate& estimate);

}  // namespace cylpose
