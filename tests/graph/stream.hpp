// A stream of small pictures of a moving red cylinder, and what one frame at a time makes of it.
#pragma once

#include <cylpose/backend.hpp>
#include <cylpose/camera.hpp>
#include <cylpose/graph/frame_task.hpp>
#include <cylpose/part.hpp>
#include <cylpose/pose.hpp>
#include <cylpose/pose_filter.hpp>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace cylpose::testing {

[[nodiscard]] CameraModel stream_camera();  ///< 200 x 150 pixels
[[nodiscard]] std::vector<PartModel> stream_parts();

/// Frame `index` of a slow motion; in some frames the cylinder jumps, so that it is not where the frame before says, in
/// some it is hidden, and some cannot be used (a failure, a wrong size). Rendered once; safe to share.
[[nodiscard]] graph::InputFrame stream_frame(int index);
inline constexpr int kStreamFrames = 24;

/// The same pictures without the bad frames in between.
[[nodiscard]] graph::InputFrame good_frame(int index);

/// What a stream must give, frame by frame, from the definition of PipelineOptions::lag: one frame at a time, with all
/// regions kept. Always by the serial backend.
[[nodiscard]] std::vector<FrameEstimate> one_at_a_time(const std::vector<graph::InputFrame>& frames, std::size_t lag,
                                                       const std::optional<FilterOptions>& filter = std::nullopt);

/// Fails the test unless status, pose, covariance and reason are equal to the last bit.
void expect_same(const FrameEstimate& actual, const FrameEstimate& expected, const std::string& what);

/// The serial backend as a device would do it: ends come from threads of its own, after random times, in any order.
[[nodiscard]] std::unique_ptr<Backend> make_slow_device(unsigned seed, int most_microseconds);

}  // namespace cylpose::testing
