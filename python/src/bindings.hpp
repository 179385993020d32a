// What each file adds to the extension module.
#pragma once

#include <pybind11/pybind11.h>

namespace cylpose::python {

namespace py = pybind11;

/// What `work` returns, which other threads of Python need not wait for.
template <typename Work>
auto without_gil(Work work) {
  const py::gil_scoped_release no_gil;
  return work();
}

void bind_backends(py::module_& module);
void bind_errors();
void bind_estimator(py::module_& module);
void bind_models(py::module_& module);
void bind_overlay(py::module_& module);
void bind_pipeline(py::module_& module);
void bind_stream(py::module_& module);

}  // namespace cylpose::python
