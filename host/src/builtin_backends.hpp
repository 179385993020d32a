// The backends that every build of the host library has.
#pragma once

#include <cylpose/backend.hpp>
#include <memory>

namespace cylpose {

[[nodiscard]] std::unique_ptr<Backend> make_opencv_backend();
[[nodiscard]] std::unique_ptr<Backend> make_serial_backend();
[[nodiscard]] std::unique_ptr<Backend> make_default_opencl_backend();  ///< where built with OpenCL

}  // namespace cylpose
