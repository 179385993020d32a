// The plots and pictures of the accuracy bench.
#pragma once

#include <opencv2/core/mat.hpp>
#include <span>
#include <vector>

#include "location.hpp"
#include "pose_outcome.hpp"

namespace cylpose::bench {

/// Bias and scatter beside the bound, one chart per influence.
[[nodiscard]] cv::Mat location_plot(std::span<const Location> locations);

/// Centre error over distance with the bound, both methods; and the histogram of the NEES with the chi-squared density.
[[nodiscard]] cv::Mat pose_plot(std::span<const Outcome> outcomes);

/// The outcomes of the default method that are farthest from their trials' truth: wrong ones first, then by error in
/// standard deviations at the bound.
[[nodiscard]] std::vector<const Outcome*> worst(std::span<const Outcome> outcomes, std::size_t count);

/// The picture with the estimate (overlay.hpp) and the true outline in green.
[[nodiscard]] cv::Mat picture_of(const Outcome& outcome, std::span<const PoseTrial> trials);

}  // namespace cylpose::bench
