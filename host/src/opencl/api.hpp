// The OpenCL C interface with owners for its handles and every error turned into an Error(kDevice) that names call,
// reason and device.
#pragma once

#define CL_TARGET_OPENCL_VERSION 120
#include <CL/cl.h>

#include <string>
#include <string_view>
#include <utility>

namespace cylpose::opencl {

/// "CL_OUT_OF_RESOURCES" for -5 and so on; the number where it has no name here.
[[nodiscard]] std::string error_name(cl_int code);

/// `where` is the device, or what was asked for where there is none yet.
[[noreturn]] void fail(std::string_view call, cl_int code, std::string_view where);

inline void check(cl_int code, std::string_view call, std::string_view where) {
  if (code != CL_SUCCESS) fail(call, code, where);
}

/// Owns one reference to an OpenCL object.
template <typename T, cl_int(CL_API_CALL* release)(T)>
class Handle {
 public:
  Handle() = default;
  explicit Handle(T object) : object_(object) {}
  Handle(Handle&& other) noexcept : object_(std::exchange(other.object_, nullptr)) {}
  Handle& operator=(Handle&& other) noexcept {
    std::swap(object_, other.object_);
    return *this;
  }
  Handle(const Handle&) = delete;
  Handle& operator=(const Handle&) = delete;
  ~Handle() { reset(); }

  void reset() {
    if (object_ != nullptr) release(std::exchange(object_, nullptr));
  }

  [[nodiscard]] T get() const { return object_; }
  [[nodiscard]] explicit operator bool() const { return object_ != nullptr; }

  /// For calls that return an object through a pointer; what was held before is released.
  [[nodiscard]] T* out() {
    reset();
    return &object_;
  }

 private:
  T object_ = nullptr;
};

using SubDevice = Handle<cl_device_id, clReleaseDevice>;
using Context = Handle<cl_context, clReleaseContext>;
using Queue = Handle<cl_command_queue, clReleaseCommandQueue>;
using Program = Handle<cl_program, clReleaseProgram>;
using Kernel = Handle<cl_kernel, clReleaseKernel>;
using Memory = Handle<cl_mem, clReleaseMemObject>;
using Event = Handle<cl_event, clReleaseEvent>;

}  // namespace cylpose::opencl
