#include "frame_results.hpp"

#include <fmt/format.h>

#include <chrono>
#include <cylpose/error.hpp>
#include <string_view>
#include <utility>
#include <vector>

#include "backends.hpp"
#include "images.hpp"
#include "models.hpp"
#include "results.hpp"
#include "text.hpp"

namespace cylpose::python {
namespace {

// A device that is late may go on reading a frame (make_opencl_backend).
void keep_until_exit(std::shared_ptr<const void> pixels) {
  (void)new std::shared_ptr<const void>(std::move(pixels));
}

std::string name_of(const graph::FrameTask& frame) {
  return frame.name.empty() ? fmt::format("frame {}", frame.id) : frame.name;
}

}  // namespace

std::unique_ptr<graph::Pipeline> make_pipeline(const PipelineArguments& arguments, ResultQueue& queue,
                                               bool keep_images) {
  const CameraModel camera = camera_of(arguments.camera);
  const std::vector<PartModel> parts = parts_of(arguments.parts);
  graph::PipelineOptions options;
  options.policy = arguments.live ? graph::Policy::kLatest : graph::Policy::kAll;
  options.lag = arguments.lag;
  if (arguments.filter) options.filter.emplace();
  const py::gil_scoped_release no_gil;
  return std::make_unique<graph::Pipeline>(
      camera, parts, make_python_backend(arguments.backend, arguments.device),
      [&queue, keep_images](const graph::FramePtr& frame) {
        if (frame->failure && frame->failure->kind() == ErrorKind::kDevice) keep_until_exit(frame->image.owner);
        if (!keep_images) frame->image.owner.reset();
        frame->field = {};
        queue.put(frame);
      },
      options);
}

py::tuple result_of(const graph::FrameTask& frame, bool with_image) {
  if (frame.failure && frame.image.view.data != nullptr) {
    throw Error(frame.failure->kind(), fmt::format("{}: {}", name_of(frame), frame.failure->what()));
  }
  const bool has_image = with_image && frame.image.view.data != nullptr;
  return py::make_tuple(frame.id, frame.timestamp_s, python_text(frame.name),
                        python_text(frame.failure ? frame.failure->what() : std::string_view()),
                        has_image ? py::object(array_on(frame.image)) : py::none(), to_python(frame.estimate));
}

graph::FramePtr next_frame(ResultQueue& queue) {
  constexpr std::chrono::milliseconds kBetweenSignals(50);
  for (;;) {
    std::optional<graph::FramePtr> frame;
    {
      const py::gil_scoped_release no_gil;
      frame = queue.take(kBetweenSignals);
    }
    if (frame) return *std::move(frame);
    if (PyErr_CheckSignals() != 0) throw py::error_already_set();
  }
}

}  // namespace cylpose::python
