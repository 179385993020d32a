// What CameraEffects asks for, one function each. Plain loops, so that the bytes are the same everywhere.
#pragma once

#include <cylpose/render.hpp>
#include <opencv2/core/mat.hpp>

#include "portable_random.hpp"

namespace cylpose {

/// Light (CV_32FC3) less `loss` times the squared distance from the middle, 1 in the corners.
[[nodiscard]] cv::Mat vignetted(const cv::Mat& light, double loss);

/// Light (CV_32FC3) with noise of a kind that depends on it; `sigma` in code values of sRGB at code 128.
[[nodiscard]] cv::Mat with_noise_in_light(const cv::Mat& light, NoiseKind kind, double sigma, PortableRandom* random);

/// Codes (CV_8UC3) plus `amount` times their difference from the 3x3 surroundings, weighted 1 2 1.
[[nodiscard]] cv::Mat sharpened(const cv::Mat& coded, double amount);

/// Codes (CV_8UC3) with the means of 2x2 blocks for their colour differences (BT.601, full range), in between linear.
[[nodiscard]] cv::Mat with_chroma_420(const cv::Mat& coded);

}  // namespace cylpose
