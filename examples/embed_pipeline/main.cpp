// Push frames, get poses: cylpose in a program that has a loop of its own.
//   embed_pipeline camera.yaml parts.yaml video.mp4
#include <cstdint>
#include <cstdio>
#include <cylpose/default_backend.hpp>
#include <cylpose/frame_pool.hpp>
#include <cylpose/graph/pipeline.hpp>
#include <opencv2/videoio.hpp>

namespace {

// Called from a thread of the pipeline, frame by frame in order.
void print(const cylpose::graph::FramePtr& frame) {
  if (frame->failure) {
    std::printf("%lld: %s\n", static_cast<long long>(frame->id), frame->failure->what());
    return;
  }
  const cylpose::PoseEstimate& part = frame->estimate.parts.front();
  const Eigen::Vector3d& center = part.pose.center_in_cam;
  std::printf("%lld: %s", static_cast<long long>(frame->id), std::string(to_string(part.status)).c_str());
  if (part.status != cylpose::PoseStatus::kNone) std::printf(" %.4f %.4f %.4f m", center.x(), center.y(), center.z());
  std::printf("\n");
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 4) {
    std::fprintf(stderr, "usage: %s camera.yaml parts.yaml video\n", argv[0]);
    return 2;
  }
  try {
    cylpose::graph::PipelineOptions options;
    options.filter.emplace();
    cylpose::graph::Pipeline pipeline(cylpose::load_camera(argv[1]), cylpose::load_parts(argv[2]),
                                      cylpose::make_default_backend().backend, print, options);

    cv::VideoCapture video(argv[3]);
    const double fps = video.get(cv::CAP_PROP_FPS);
    const cylpose::FramePool pool;
    for (std::int64_t id = 0;; ++id) {
      const cv::Mat image = pool.filled([&](cv::Mat& frame) { video.read(frame); });
      if (image.empty()) break;
      pipeline.put({id, static_cast<double>(id) / fps, "", cylpose::graph::shared(image), {}});
    }
    pipeline.wait_for_all();
    const cylpose::graph::PipelineStatistics statistics = pipeline.statistics();
    std::printf("%llu frames, %.2f ms from put to sink in the median\n",
                static_cast<unsigned long long>(statistics.delivered), statistics.latency.median_ms);
    return statistics.delivered > 0 ? 0 : 1;
  } catch (const cylpose::Error& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
}
