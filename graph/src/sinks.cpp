#include <cylpose/graph/sinks.hpp>
#include <cylpose/overlay.hpp>
#include <utility>

namespace cylpose::graph {

Sink write_poses(std::shared_ptr<PoseWriter> writer) {
  return [writer = std::move(writer)](const FramePtr& frame) {
    writer->write(frame->id, frame->timestamp_s, frame->estimate);
  };
}

Sink draw_overlays(CameraModel camera, std::vector<PartModel> parts,
                   std::function<void(const FramePtr& frame, const cv::Mat& picture)> show) {
  return [camera = std::move(camera), parts = std::move(parts), show = std::move(show)](const FramePtr& frame) {
    if (frame->failure) return;
    show(frame, overlay(mat_of(frame->image.view), camera, parts, frame->estimate));
  };
}

}  // namespace cylpose::graph
