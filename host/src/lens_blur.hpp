// The blur of a lens, which spreads light before pixels gather it.
#pragma once

#include <cylpose/render.hpp>
#include <opencv2/core/mat.hpp>

namespace cylpose {

/// The light on every pixel behind a lens that spreads a point of light by `sigma_px` > 0. What falls beside the
/// picture comes back mirrored, so that no light is lost.
[[nodiscard]] cv::Mat blurred(const SceneLight& light, BlurKernel kernel, double sigma_px);

}  // namespace cylpose
