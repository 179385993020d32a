#include <cylpose/error.hpp>
#include <exception>

#include "bindings.hpp"
#include "text.hpp"

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
    const py::object kind = py::module_::import("cylpose._errors").attr(class_of(error.kind()));
    PyErr_SetObject(kind.ptr(), python_text(error.what()).ptr());
  }
}

}  // namespace

void bind_errors() {
  py::register_local_exception_translator(translate);
}

}  // namespace cylpose::python
