// In place of the OpenCL backend in a build without it.
#include <cylpose/error.hpp>
#include <cylpose/opencl_devices.hpp>

namespace cylpose {

std::vector<OpenclDevice> opencl_devices() {
  return {};
}

std::unique_ptr<OpenclBackend> make_opencl_backend(const OpenclOptions& /*options*/) {
  throw Error(ErrorKind::kDevice, "this build of cylpose has no OpenCL; build it with -DCYLPOSE_WITH_OPENCL=ON");
}

std::string_view kernel_hash() {
  return "none";
}

}  // namespace cylpose
