// The package's dataclasses CameraModel and PartModel as those of C++, and their files.
#pragma once

#include <pybind11/pybind11.h>

#include <cylpose/camera.hpp>
#include <cylpose/part.hpp>
#include <vector>

namespace cylpose::python {

namespace py = pybind11;

/// The values of a cylpose.CameraModel. TypeError for a field of another type.
[[nodiscard]] CameraModel camera_of(const py::object& camera);

/// The values of several cylpose.PartModel.
[[nodiscard]] std::vector<PartModel> parts_of(const py::iterable& parts);

}  // namespace cylpose::python
