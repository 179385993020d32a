// The OpenCL backend: which devices there are, which to use, and how.
#pragma once

#include <chrono>
#include <cstdint>
#include <cylpose/backend.hpp>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace cylpose {

struct OpenclDevice {
  int index = 0;  ///< place in opencl_devices()
  std::string platform;
  std::string name;
  std::string type;  ///< "cpu", "gpu", "accelerator" or "custom"
  int compute_units = 0;
  std::uint64_t memory_bytes = 0;
  std::string device_version;
  std::string driver_version;
  bool shares_memory = false;  ///< with the host, so the device says; frames are then used where they lie if that pays
  int sub_devices = 0;         ///< at most so many parts can be made of it; 0: it cannot be divided
  std::string unusable;        ///< why cylpose cannot use it; empty when it can
};

/// All devices of all platforms. Empty where there is no OpenCL, and in a build without it.
[[nodiscard]] std::vector<OpenclDevice> opencl_devices();

struct OpenclOptions {
  /// What to run on: one or more devices, separated by commas. Each is the first usable device that fits an index
  /// ("1"), a type ("gpu") or part of a name or platform in any case ("radeon"); "/N" divides it into N parts
  /// ("cpu/2"). Empty: what the environment variable CYLPOSE_DEVICE says; without that the first usable device, GPUs
  /// before accelerators before CPUs. Several devices share large frames by their measured speed.
  std::string device;
  /// The longest wait for the device in one frame. What takes longer counts as failed, and the memory that the device
  /// was using is given up, for the image see make_opencl_backend. Above zero. No cost.
  std::chrono::milliseconds timeout{5000};
  /// Ask the device for the time of each kernel, for EdgeField::times. Costs some 20 us a frame.
  bool profile = false;
  /// Keep built programs on disk, so that the next process starts faster.
  bool cache_programs = true;
  /// Where to keep them. Empty: cylpose/ in $XDG_CACHE_HOME, else in ~/.cache.
  std::filesystem::path cache_dir;
  /// Copy every frame to the device, even where reading it in place was quicker when the backend was made. A device
  /// that is late then has no hold on the caller's image. Costs the copy: some 0.1 ms for 1280x720.
  bool copy_frames = false;
  /// Called once for a device that fails or is late: the others do its work from then on. From any thread that detects.
  /// Where no other is left, detect throws instead.
  std::function<void(const OpenclDevice& device, const std::string& why)> on_device_lost;
  /// Rows that a device does at once when there are several; 0: as many as its speed deserves.
  int strip_rows = 0;
  /// Tuning of the kernels (kernels/layout.cl, kernels/gate.cl); 0: by the device's type.
  int group_size = 0;
  int span_words = 0;

  [[nodiscard]] bool is_valid(std::string* why) const;
};

class OpenclBackend : public Backend {
 public:
  /// The devices in use.
  [[nodiscard]] virtual std::vector<OpenclDevice> devices() const = 0;
};

/// Throws Error(kInput) for a device that does not exist (the text lists those that do), Error(kDevice) where one does
/// not work. After a timeout in detect the device may still be reading the image: keep it until the process ends, or
/// use a device that does not share memory.
[[nodiscard]] std::unique_ptr<OpenclBackend> make_opencl_backend(const OpenclOptions& options = {});

/// Identifies the kernels of this build (SHA-256 of their text, hexadecimal): machines with the same one give the same
/// answers. "none" in a build without OpenCL.
[[nodiscard]] std::string_view kernel_hash();

}  // namespace cylpose
