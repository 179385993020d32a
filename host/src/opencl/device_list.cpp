#include "opencl/device_list.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cstdlib>
#include <cylpose/error.hpp>
#include <optional>
#include <utility>

namespace cylpose::opencl {
namespace {

// The loader's answer where no platform is installed; its header is not part of OpenCL 1.2.
constexpr cl_int kNoPlatform = -1001;

std::string trimmed(std::string text) {
  text.resize(text.find_last_not_of(std::string_view(" \0", 2)) + 1);
  return text;
}

std::string platform_text(cl_platform_id platform, cl_platform_info what) {
  constexpr std::string_view kWhere = "an OpenCL platform";
  std::size_t size = 0;
  check(clGetPlatformInfo(platform, what, 0, nullptr, &size), "clGetPlatformInfo", kWhere);
  std::string text(size, '\0');
  check(clGetPlatformInfo(platform, what, size, text.data(), nullptr), "clGetPlatformInfo", kWhere);
  return trimmed(text);
}

std::vector<cl_platform_id> platforms() {
  constexpr std::string_view kWhere = "this machine";
  cl_uint count = 0;
  const cl_int code = clGetPlatformIDs(0, nullptr, &count);
  if (code == kNoPlatform || count == 0) return {};
  check(code, "clGetPlatformIDs", kWhere);
  std::vector<cl_platform_id> ids(count);
  check(clGetPlatformIDs(count, ids.data(), nullptr), "clGetPlatformIDs", kWhere);
  return ids;
}

std::vector<cl_device_id> devices_of(cl_platform_id platform, std::string_view name) {
  cl_uint count = 0;
  const cl_int code = clGetDeviceIDs(platform, CL_DEVICE_TYPE_ALL, 0, nullptr, &count);
  if (code == CL_DEVICE_NOT_FOUND || count == 0) return {};
  check(code, "clGetDeviceIDs", name);
  std::vector<cl_device_id> ids(count);
  check(clGetDeviceIDs(platform, CL_DEVICE_TYPE_ALL, count, ids.data(), nullptr), "clGetDeviceIDs", name);
  return ids;
}

std::string type_name(cl_device_type type) {
  if ((type & CL_DEVICE_TYPE_GPU) != 0) return "gpu";
  if ((type & CL_DEVICE_TYPE_ACCELERATOR) != 0) return "accelerator";
  if ((type & CL_DEVICE_TYPE_CPU) != 0) return "cpu";
  return "custom";
}

std::string reason_against(cl_device_id id, std::string_view name) {
  if (device_value<cl_bool>(id, CL_DEVICE_AVAILABLE, name) == CL_FALSE) return "not available";
  if (device_value<cl_bool>(id, CL_DEVICE_COMPILER_AVAILABLE, name) == CL_FALSE) return "has no compiler";
  if (device_value<cl_bool>(id, CL_DEVICE_ENDIAN_LITTLE, name) == CL_FALSE) return "is big-endian";
  return {};
}

OpenclDevice described(cl_device_id id, const std::string& platform, int index) {
  OpenclDevice device;
  device.index = index;
  device.platform = platform;
  device.name = device_text(id, CL_DEVICE_NAME, platform);
  device.type = type_name(device_value<cl_device_type>(id, CL_DEVICE_TYPE, device.name));
  device.compute_units = static_cast<int>(device_value<cl_uint>(id, CL_DEVICE_MAX_COMPUTE_UNITS, device.name));
  device.memory_bytes = device_value<cl_ulong>(id, CL_DEVICE_GLOBAL_MEM_SIZE, device.name);
  device.device_version = device_text(id, CL_DEVICE_VERSION, device.name);
  device.driver_version = device_text(id, CL_DRIVER_VERSION, device.name);
  device.shares_memory = device_value<cl_bool>(id, CL_DEVICE_HOST_UNIFIED_MEMORY, device.name) != CL_FALSE;
  device.sub_devices = static_cast<int>(device_value<cl_uint>(id, CL_DEVICE_PARTITION_MAX_SUB_DEVICES, device.name));
  device.unusable = reason_against(id, device.name);
  return device;
}

std::string lower(std::string_view text) {
  std::string result(text);
  std::ranges::transform(result, result.begin(),
                         [](char c) { return static_cast<char>(std::tolower(static_cast<unsigned char>(c))); });
  return result;
}

bool fits(const OpenclDevice& device, const std::string& wanted) {
  int index = 0;
  const char* end = wanted.data() + wanted.size();
  if (const auto parsed = std::from_chars(wanted.data(), end, index); parsed.ec == std::errc{} && parsed.ptr == end) {
    return device.index == index;
  }
  const std::string text = lower(wanted);
  constexpr std::array<std::string_view, 4> kTypes{"cpu", "gpu", "accelerator", "custom"};
  if (std::ranges::find(kTypes, text) != kTypes.end()) return device.type == text;
  return lower(device.name).find(text) != std::string::npos || lower(device.platform).find(text) != std::string::npos;
}

// Lower is better.
int rank(const OpenclDevice& device) {
  if (device.type == "gpu") return 0;
  if (device.type == "accelerator") return 1;
  return device.type == "cpu" ? 2 : 3;
}

std::string listed(const std::vector<LocalDevice>& devices) {
  if (devices.empty()) return "there is none; install an OpenCL driver, for a CPU for instance pocl-opencl-icd";
  std::string text = "there are:";
  for (const LocalDevice& device : devices) {
    text += "\n  " + display_name(device.info) + ", " + device.info.type;
    if (!device.info.unusable.empty()) text += ", unusable: " + device.info.unusable;
  }
  return text;
}

}  // namespace

std::string device_text(cl_device_id device, cl_device_info what, std::string_view where) {
  std::size_t size = 0;
  check(clGetDeviceInfo(device, what, 0, nullptr, &size), "clGetDeviceInfo", where);
  std::string text(size, '\0');
  check(clGetDeviceInfo(device, what, size, text.data(), nullptr), "clGetDeviceInfo", where);
  return trimmed(text);
}

std::string display_name(const OpenclDevice& device) {
  return fmt::format("device {} '{}' of '{}'", device.index, device.name, device.platform);
}

std::vector<LocalDevice> local_devices() {
  std::vector<LocalDevice> found;
  for (cl_platform_id platform : platforms()) {
    const std::string name = platform_text(platform, CL_PLATFORM_NAME);
    const std::string version = platform_text(platform, CL_PLATFORM_VERSION);
    for (cl_device_id id : devices_of(platform, name)) {
      found.push_back({platform, id, described(id, name, static_cast<int>(found.size())), version});
    }
  }
  return found;
}

LocalDevice chosen_device(const std::string& wanted) {
  std::string selector = wanted;
  std::string source = "the option";
  if (selector.empty()) {
    const char* variable = std::getenv("CYLPOSE_DEVICE");
    selector = variable == nullptr ? "" : variable;
    source = "CYLPOSE_DEVICE";
  }
  const std::vector<LocalDevice> devices = local_devices();
  std::optional<LocalDevice> best;
  for (const LocalDevice& device : devices) {
    if (!device.info.unusable.empty()) continue;
    if (!selector.empty()) {
      if (fits(device.info, selector)) return device;
    } else if (!best || rank(device.info) < rank(best->info)) {
      best = device;
    }
  }
  if (best) return *best;
  if (selector.empty()) {
    throw Error(ErrorKind::kDevice, "no usable OpenCL device: " + listed(devices));
  }
  throw Error(ErrorKind::kInput,
              fmt::format("no usable OpenCL device fits '{}' ({}): {}", selector, source, listed(devices)));
}

}  // namespace cylpose::opencl
