// The backend that Python asks for.
#pragma once

#include <cylpose/backend.hpp>
#include <memory>
#include <string>

namespace cylpose::python {

/// `name` as Estimator's argument `backend`; `device`: what opencl runs on (OpenclOptions::device), empty for its own
/// choice. What the user should know goes to the logger `cylpose`. Call it without the GIL. Throws Error(kInput) for
/// unknown names, Error(kDevice) for a device that does not work.
[[nodiscard]] std::unique_ptr<Backend> make_python_backend(const std::string& name, const std::string& device);

}  // namespace cylpose::python
