// Where frames go when their poses are known.
#pragma once

#include <cylpose/camera.hpp>
#include <cylpose/graph/frame_task.hpp>
#include <cylpose/part.hpp>
#include <cylpose/pose_io.hpp>
#include <functional>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <vector>

namespace cylpose::graph {

/// Gets frames one after the other. May keep the frame; the pixels then stay in use.
using Sink = std::function<void(const FramePtr& frame)>;

/// Writes CSV, JSON lines or TUM rows, failed frames as `none`. Throws what PoseWriter::write throws.
[[nodiscard]] Sink write_poses(std::shared_ptr<PoseWriter> writer);

/// Draws the overlay (overlay.hpp) into a copy of each frame that has an image and hands it to `show`.
[[nodiscard]] Sink draw_overlays(CameraModel camera, std::vector<PartModel> parts,
                                 std::function<void(const FramePtr& frame, const cv::Mat& picture)> show);

}  // namespace cylpose::graph
