// A run as bars: where the time goes, by backend.
#pragma once

#include <opencv2/core/mat.hpp>

#include "results.hpp"

namespace cylpose::bench {

/// Detection on the left, estimation on the right; a group of bars for each scene and size, its longest bar the full
/// width. Coloured: the stages. Grey, up to the frame's median time: what lies between them.
[[nodiscard]] cv::Mat stage_picture(const BenchRun& run);

}  // namespace cylpose::bench
