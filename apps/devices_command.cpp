#include <fmt/format.h>

#include <cstdint>
#include <cstdlib>
#include <cylpose/backend.hpp>
#include <cylpose/error.hpp>
#include <cylpose/opencl_devices.hpp>
#include <string>
#include <vector>

#include "commands.hpp"
#include "help_text.hpp"
#include "output.hpp"

namespace cylpose::apps {

namespace {

std::string gibibytes(std::uint64_t bytes) {
  return fmt::format("{:.1f} GiB", static_cast<double>(bytes) / (1 << 30));
}

std::string list_of_backends() {
  std::string text = "backends (estimate --backend NAME)\n";
  for (const BackendInfo& backend : backends()) {
    text += fmt::format("  {:<10} {}\n", backend.name, backend.description);
  }
  return text;
}

// What the opencl backend runs on when nothing else is said.
std::string current_choice() {
  try {
    std::string text;
    for (const OpenclDevice& device : make_opencl_backend()->devices()) {
      text += fmt::format("{}{} ({})", text.empty() ? "" : ", ", device.index, device.name);
    }
    return text;
  } catch (const Error& error) {
    return fmt::format("none: {}", error.what());
  }
}

std::string list_of_devices() {
  const std::vector<OpenclDevice> devices = opencl_devices();
  std::string text = "OpenCL devices (estimate --backend opencl --device DEVICE, or CYLPOSE_DEVICE=DEVICE)\n";
  for (const OpenclDevice& device : devices) {
    text += fmt::format("  {}  {}\n", device.index, device.name);
    text += fmt::format("     {}, {} units, {} {}, {}\n", device.type, device.compute_units,
                        gibibytes(device.memory_bytes), device.shares_memory ? "shared with the host" : "of its own",
                        device.sub_devices > 1 ? fmt::format("can be divided into up to {}", device.sub_devices)
                                               : std::string("cannot be divided"));
    text += fmt::format("     {}; {}; driver {}\n", device.platform, device.device_version, device.driver_version);
    if (!device.unusable.empty()) text += fmt::format("     cannot be used: {}\n", device.unusable);
  }
  if (devices.empty()) text += "  none; install a driver, for a CPU for instance pocl-opencl-icd\n";
  const char* variable = std::getenv("CYLPOSE_DEVICE");
  text += fmt::format("selected{}: {}\n",
                      variable == nullptr ? std::string() : fmt::format(" by CYLPOSE_DEVICE={}", variable),
                      current_choice());
  return text;
}

}  // namespace

void add_devices_command(CLI::App& app) {
  CLI::App* command = app.add_subcommand("devices", "List what can do the per-pixel work (estimate --backend NAME).");
  set_examples(*command, {"cylpose devices"});
  command->callback([] { write_stdout(list_of_backends() + list_of_devices()); });
}

}  // namespace cylpose::apps
