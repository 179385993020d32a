#include "opencl/device_list.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cstdlib>
#include <cylpose/error.hpp>
#include <iterator>
#include <sstream>
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
  std::string text;
  for (const LocalDevice& device : devices) text += "\n  " + display_name(device.info) + ", " + device.info.type;
  return text;
}

// Those that can be used; throws where there is none.
std::vector<LocalDevice> usable(std::vector<LocalDevice> devices) {
  std::string reasons;
  for (const LocalDevice& device : devices) {
    if (!device.info.unusable.empty()) reasons += "; " + display_name(device.info) + " " + device.info.unusable;
  }
  std::erase_if(devices, [](const LocalDevice& device) { return !device.info.unusable.empty(); });
  if (devices.empty()) {
    throw Error(ErrorKind::kDevice,
                "there is no usable OpenCL device; install a driver, for a CPU for instance pocl-opencl-icd" + reasons);
  }
  return devices;
}

struct Selector {
  std::string device;
  int parts;
};

// "gpu", or "cpu/2" for a device in two parts.
Selector parsed(const std::string& text, const std::string& source) {
  const std::size_t slash = text.rfind('/');
  int parts = 1;
  if (slash != std::string::npos) {
    const char* end = text.data() + text.size();
    const auto number = std::from_chars(text.data() + slash + 1, end, parts);
    if (number.ec != std::errc{} || number.ptr != end || parts < 1) {
      throw Error(ErrorKind::kInput,
                  fmt::format("OpenCL device '{}' ({}): what follows the '/' must be a number of parts", text, source));
    }
  }
  const std::string device = text.substr(0, slash);
  if (device.empty()) {
    throw Error(ErrorKind::kInput, fmt::format("OpenCL device '{}' ({}) has no index, type or name", text, source));
  }
  return {device, parts};
}

LocalDevice copy_of(const LocalDevice& whole) {
  return {whole.platform, whole.id, whole.info, whole.platform_version, SubDevice()};
}

std::vector<LocalDevice> divided(const LocalDevice& whole, int parts) {
  const std::string name = display_name(whole.info);
  if (parts > whole.info.sub_devices || parts > whole.info.compute_units) {
    throw Error(ErrorKind::kInput, fmt::format("{} cannot be divided into {} parts, at most into {}", name, parts,
                                               std::min(whole.info.sub_devices, whole.info.compute_units)));
  }
  const std::array<cl_device_partition_property, 3> equally{CL_DEVICE_PARTITION_EQUALLY,
                                                            whole.info.compute_units / parts, 0};
  cl_uint count = 0;
  check(clCreateSubDevices(whole.id, equally.data(), 0, nullptr, &count), "clCreateSubDevices", name);
  std::vector<cl_device_id> ids(count);
  check(clCreateSubDevices(whole.id, equally.data(), count, ids.data(), nullptr), "clCreateSubDevices", name);
  std::vector<LocalDevice> devices;
  for (cl_device_id id : ids) {
    LocalDevice& device = devices.emplace_back(copy_of(whole));
    device.id = id;
    device.part = SubDevice(id);
    device.info.compute_units = whole.info.compute_units / parts;
    device.info.name += fmt::format(" (part {} of {})", devices.size(), count);
  }
  return devices;
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
      found.push_back({platform, id, described(id, name, static_cast<int>(found.size())), version, SubDevice()});
    }
  }
  return found;
}

std::vector<LocalDevice> chosen_devices(const std::string& wanted) {
  std::string selectors = wanted;
  std::string source = "the option";
  if (selectors.empty()) {
    const char* variable = std::getenv("CYLPOSE_DEVICE");
    selectors = variable == nullptr ? "" : variable;
    source = "CYLPOSE_DEVICE";
  }
  const std::vector<LocalDevice> devices = usable(local_devices());
  std::vector<LocalDevice> chosen;
  if (selectors.empty()) {
    const auto best = std::ranges::min_element(devices, {}, [](const LocalDevice& d) { return rank(d.info); });
    chosen.push_back(copy_of(*best));
    return chosen;
  }
  std::istringstream stream(selectors);
  for (std::string text; std::getline(stream, text, ',');) {
    const Selector selector = parsed(text, source);
    const auto found =
        std::ranges::find_if(devices, [&](const LocalDevice& device) { return fits(device.info, selector.device); });
    if (found == devices.end()) {
      throw Error(ErrorKind::kInput, fmt::format("no usable OpenCL device fits '{}' ({}); there are:{}",
                                                 selector.device, source, listed(devices)));
    }
    if (selector.parts == 1) {
      chosen.push_back(copy_of(*found));
    } else {
      std::ranges::move(divided(*found, selector.parts), std::back_inserter(chosen));
    }
  }
  return chosen;
}

}  // namespace cylpose::opencl
