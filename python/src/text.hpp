// Text that may hold the names of files, which may be in any encoding: as os.fsdecode and os.fsencode have it.
#pragma once

#include <pybind11/pybind11.h>

#include <string>
#include <string_view>

namespace cylpose::python {

namespace py = pybind11;

[[nodiscard]] inline py::str python_text(std::string_view text) {
  const auto size = static_cast<py::ssize_t>(text.size());
  PyObject* const decoded = PyUnicode_DecodeFSDefaultAndSize(text.data(), size);
  if (decoded == nullptr) throw py::error_already_set();
  return py::reinterpret_steal<py::str>(decoded);
}

[[nodiscard]] inline std::string native_text(const py::str& text) {
  PyObject* const encoded = PyUnicode_EncodeFSDefault(text.ptr());
  if (encoded == nullptr) throw py::error_already_set();
  return py::reinterpret_steal<py::bytes>(encoded);
}

}  // namespace cylpose::python
