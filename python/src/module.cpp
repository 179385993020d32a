// The extension module: what the Python files of the package are built on. The names in it are no interface of theirs.
#include <cylpose/pose_io.hpp>
#include <cylpose/version.hpp>
#include <string>

#include "bindings.hpp"

PYBIND11_MODULE(_cylpose, module) {
  module.doc() = "The C++ side of cylpose; use the package cylpose.";
  module.attr("VERSION") = cylpose::kVersion;
  module.attr("POSES_HEADER") = std::string(cylpose::kPosesHeader);
  cylpose::python::bind_errors();
  cylpose::python::bind_backends(module);
  cylpose::python::bind_models(module);
  cylpose::python::bind_estimator(module);
  cylpose::python::bind_pipeline(module);
  cylpose::python::bind_stream(module);
  cylpose::python::bind_overlay(module);
}
