// What Stream and Pipeline have in common: a graph::Pipeline that ends in a queue, and the queue's frames as Python's.
#pragma once

#include <pybind11/pybind11.h>

#include <cylpose/graph/pipeline.hpp>
#include <memory>
#include <optional>
#include <string>

#include "result_queue.hpp"

namespace cylpose::python {

namespace py = pybind11;

/// The arguments that Stream and Pipeline share.
struct PipelineArguments {
  py::object camera;
  py::iterable parts;
  std::string backend;
  std::string device;
  bool filter;
  bool live;
  int lag;
};

/// A pipeline into `queue`, which must outlive it. With the GIL, which it gives up meanwhile.
[[nodiscard]] std::unique_ptr<graph::Pipeline> make_pipeline(const PipelineArguments& arguments, ResultQueue& queue,
                                                             bool keep_images);

/// (frame, timestamp_s, name, error, image, estimate) of a finished frame. Throws the failure of a frame that has
/// pixels: what went wrong there would go wrong with the next one, too.
[[nodiscard]] py::tuple result_of(const graph::FrameTask& frame, bool with_image);

/// The next finished frame, waited for without the GIL and with an eye on signals. Null at the end.
[[nodiscard]] graph::FramePtr next_frame(ResultQueue& queue);

}  // namespace cylpose::python
