#include "images.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cylpose/error.hpp>
#include <limits>
#include <memory>
#include <string>

namespace cylpose::python {
namespace {

PixelFormat format_from(std::string_view color_order) {
  if (color_order == "bgr") return PixelFormat::kBgr8;
  if (color_order == "rgb") return PixelFormat::kRgb8;
  throw Error(ErrorKind::kInput, fmt::format("unknown color_order '{}'; write bgr or rgb", color_order));
}

std::string printed(const py::object& object) {
  return py::str(object).cast<std::string>();
}

// What does not fit in an int is too large for require_usable as well.
int pixels(py::ssize_t count) {
  return static_cast<int>(std::min<py::ssize_t>(count, std::numeric_limits<int>::max()));
}

}  // namespace

ImageView view_of_array(const py::object& image, std::string_view color_order) {
  if (!py::isinstance<py::array>(image)) {
    throw py::type_error(fmt::format("image is a {}; give a NumPy array, for instance numpy.asarray(image)",
                                     Py_TYPE(image.ptr())->tp_name));
  }
  const auto array = py::reinterpret_borrow<py::array>(image);
  const py::ssize_t channels = array.ndim() == 3 ? array.shape(2) : 1;
  if (!py::isinstance<py::array_t<std::uint8_t>>(image) || array.ndim() < 2 || array.ndim() > 3 ||
      (channels != 1 && channels != 3)) {
    throw Error(
        ErrorKind::kInput,
        fmt::format("image is an array of {} of shape {}; cylpose takes 8-bit images of 1 or 3 channels: uint8 of "
                    "shape (height, width) or (height, width, 3)",
                    printed(array.dtype()), printed(image.attr("shape"))));
  }
  ImageView view;
  view.data = static_cast<const std::uint8_t*>(array.data());
  view.height = pixels(array.shape(0));
  view.width = pixels(array.shape(1));
  view.format = channels == 1 ? PixelFormat::kGray8 : format_from(color_order);
  // The stride along a side of length 1 means nothing.
  if ((view.width > 1 && array.strides(1) != channels) || (channels > 1 && array.strides(2) != 1)) {
    throw Error(ErrorKind::kInput,
                fmt::format("image has the strides {}; the pixels of a row must lie side by side: give "
                            "numpy.ascontiguousarray(image), or color_order for another order of the channels",
                            printed(image.attr("strides"))));
  }
  view.stride = view.height > 1 ? array.strides(0) : view.width * channels;
  return view;
}

py::array array_on(const graph::SharedImage& image) {
  using Owner = std::shared_ptr<const void>;
  const ImageView& view = image.view;
  const py::capsule owner(new Owner(image.owner), [](void* kept) { delete static_cast<Owner*>(kept); });
  if (view.format == PixelFormat::kGray8) {
    return py::array_t<std::uint8_t>({view.height, view.width}, {view.stride, std::ptrdiff_t{1}}, view.data, owner);
  }
  return py::array_t<std::uint8_t>({view.height, view.width, 3}, {view.stride, std::ptrdiff_t{3}, std::ptrdiff_t{1}},
                                   view.data, owner);
}

}  // namespace cylpose::python
