// The devices of this machine, and the choice among them.
#pragma once

#include <cylpose/opencl_devices.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "opencl/api.hpp"

namespace cylpose::opencl {

struct LocalDevice {
  cl_platform_id platform;
  cl_device_id id;
  OpenclDevice info;
  std::string platform_version;
  SubDevice part;  ///< keeps `id` where that is a part of a device
};

[[nodiscard]] std::vector<LocalDevice> local_devices();

/// What a device is called in messages: index, name and platform.
[[nodiscard]] std::string display_name(const OpenclDevice& device);

/// By OpenclOptions::device, else CYLPOSE_DEVICE, else the best; at least one. Throws Error(kInput) where nothing fits,
/// Error(kDevice) where there is nothing.
[[nodiscard]] std::vector<LocalDevice> chosen_devices(const std::string& wanted);

/// A text or number that the device tells about itself. Throws Error(kDevice).
[[nodiscard]] std::string device_text(cl_device_id device, cl_device_info what, std::string_view where);
template <typename T>
[[nodiscard]] T device_value(cl_device_id device, cl_device_info what, std::string_view where) {
  T value{};
  check(clGetDeviceInfo(device, what, sizeof value, &value, nullptr), "clGetDeviceInfo", where);
  return value;
}

}  // namespace cylpose::opencl
