// NumPy arrays as images, and images as NumPy arrays, without a copy.
#pragma once

#include <pybind11/numpy.h>

#include <cylpose/graph/frame_task.hpp>
#include <cylpose/image.hpp>
#include <string_view>

namespace cylpose::python {

namespace py = pybind11;

/// Views the pixels of an array of uint8 of shape (height, width, 3) or (height, width); rows may be any distance
/// apart. The array must outlive the view. `color_order`: "bgr" or "rgb". Throws Error(kInput) for any other array,
/// TypeError for what is no array.
[[nodiscard]] ImageView view_of_array(const py::object& image, std::string_view color_order);

/// An array on the image's pixels, which it keeps alive.
[[nodiscard]] py::array array_on(const graph::SharedImage& image);

}  // namespace cylpose::python
