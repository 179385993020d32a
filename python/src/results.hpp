// Estimates as plain Python values, of which the package makes its dataclasses; and back, for drawing.
#pragma once

#include <pybind11/pybind11.h>

#include <cylpose/pose.hpp>

namespace cylpose::python {

namespace py = pybind11;

/// (searched, parts, times): the region (x, y, width, height), per part the values of cylpose.PoseEstimate's fields
/// behind `name`, and the milliseconds of each stage by its name. What a part without a pose has no value for is NaN.
[[nodiscard]] py::tuple to_python(const FrameEstimate& estimate);

/// The C++ estimate of a cylpose.FrameEstimate, without its times.
[[nodiscard]] FrameEstimate frame_estimate_of(const py::object& estimate);

}  // namespace cylpose::python
