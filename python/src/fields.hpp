// Fields of Python objects, with messages that name them.
#pragma once

#include <fmt/format.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <string>

namespace cylpose::python {

namespace py = pybind11;

/// `object.name` as T. TypeError when it is of another type; `wanted` says what it should be.
template <typename T>
[[nodiscard]] T field(const py::handle& object, const char* name, const char* wanted) {
  const py::object value = object.attr(name);
  try {
    return value.cast<T>();
  } catch (const py::cast_error&) {
    throw py::type_error(fmt::format("{}.{} is {}; it must be {}", Py_TYPE(object.ptr())->tp_name, name,
                                     py::repr(value).cast<std::string>(), wanted));
  }
}

}  // namespace cylpose::python
