// The backend for users who name none.
#pragma once

#include <cylpose/backend.hpp>
#include <cylpose/opencl_devices.hpp>
#include <memory>
#include <string>

namespace cylpose {

struct DefaultBackend {
  std::unique_ptr<Backend> backend;
  std::string note;  ///< why it is not OpenCL, to be told once; empty when it is
};

/// OpenCL where a device is found that works, else serial. Both give the same answer bit for bit.
/// Throws Error(kInput) when `options` or CYLPOSE_DEVICE ask for a device that does not exist.
[[nodiscard]] DefaultBackend make_default_backend(const OpenclOptions& options = {});

}  // namespace cylpose
