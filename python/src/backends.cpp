#include "backends.hpp"

#include <fmt/format.h>

#include <cylpose/default_backend.hpp>
#include <cylpose/error.hpp>
#include <cylpose/opencl_devices.hpp>

#include "bindings.hpp"

namespace cylpose::python {
namespace {

void log_warning(const std::string& text) {
  const py::gil_scoped_acquire gil;
  try {
    py::module_::import("logging").attr("getLogger")("cylpose").attr("warning")("%s", text);
  } catch (py::error_already_set& error) {
    error.discard_as_unraisable("cylpose: warning");
  }
}

OpenclOptions opencl_options(const std::string& device) {
  OpenclOptions options;
  options.device = device;
  options.on_device_lost = [](const OpenclDevice& lost, const std::string& why) {
    log_warning(fmt::format("going on without {}: {}", lost.name, why));
  };
  return options;
}

// In the order of the dataclass's fields.
py::tuple tuple_of(const OpenclDevice& device) {
  return py::make_tuple(device.index, device.platform, device.name, device.type, device.compute_units,
                        device.memory_bytes, device.device_version, device.driver_version, device.shares_memory,
                        device.sub_devices, device.unusable);
}

}  // namespace

std::unique_ptr<Backend> make_python_backend(const std::string& name, const std::string& device) {
  if (name == "opencl") return make_opencl_backend(opencl_options(device));
  if (name == "default") {
    DefaultBackend chosen = make_default_backend(opencl_options(device));
    if (!chosen.note.empty()) log_warning(chosen.note);
    return std::move(chosen.backend);
  }
  if (device.empty()) return make_backend(name);
  throw Error(
      ErrorKind::kInput,
      fmt::format("device '{}': only the backend opencl runs on devices; leave out the backend '{}'", device, name));
}

void bind_backends(py::module_& module) {
  module.def("backends", [] {
    py::dict descriptions;
    for (const BackendInfo& backend : backends()) descriptions[py::str(backend.name)] = backend.description;
    return descriptions;
  });
  module.def("devices", [] {
    const std::vector<OpenclDevice> found = without_gil(opencl_devices);
    py::list devices;
    for (const OpenclDevice& device : found) devices.append(tuple_of(device));
    return devices;
  });
}

}  // namespace cylpose::python
