#include <algorithm>
#include <cylpose/default_backend.hpp>
#include <cylpose/error.hpp>

#include "builtin_backends.hpp"

namespace cylpose {
namespace {

DefaultBackend serial_because(const std::string& why) {
  return {make_serial_backend(), why + "; the serial backend does the per-pixel work"};
}

}  // namespace

DefaultBackend make_default_backend(const OpenclOptions& options) {
  const std::vector<OpenclDevice> devices = opencl_devices();
  if (std::ranges::none_of(devices, [](const OpenclDevice& device) { return device.unusable.empty(); })) {
    return serial_because("no usable OpenCL device found");
  }
  try {
    return {make_opencl_backend(options), ""};
  } catch (const Error& error) {
    if (error.kind() != ErrorKind::kDevice) throw;
    return serial_because(error.what());
  }
}

}  // namespace cylpose
