#include <cylpose/error.hpp>
#include <exception>

#include "bindings.hpp"

namespace cylpose::python {
namespace {

const char* class_of(ErrorKind kind) {
  switch (kind) {
    case ErrorKind::kInput:
      return "InputError";
    case ErrorKind::kOutput:
      return "OutputError";
    case ErrorKind::kDevice:
      return "DeviceError";
  }
  return "Error";
}

void translate(std::exception_ptr failure) {
  try {
    std::rethrow_exception(std::move(failure));
  } catch (const Error& error) {
    // Messages name files, whose names may be in any encoding.
    const auto text = py::reinterpret_steal<py::object>(PyUnicode_DecodeFSDefault(error.what()));
    PyErr_SetObject(py::module_::import("cylpose._errors").attr(class_of(error.kind())).ptr(), text.ptr());
  }
}

}  // namespace

void bind_errors() {
  py::register_local_exception_translator(translate);
}

}  // namespace cylpose::python
