// From kernel source to a program for one device.
#pragma once

#include <cylpose/image.hpp>
#include <string>

#include "opencl/api.hpp"
#include "opencl/program_cache.hpp"

namespace cylpose::opencl {

/// The -D parameters of the kernels.
struct KernelParameters {
  PixelFormat format = PixelFormat::kBgr8;
  int group_size = 1;
  int span_words = 1;
};

[[nodiscard]] std::string build_options(const KernelParameters& parameters);

struct ProgramTarget {
  cl_context context = nullptr;
  cl_device_id device = nullptr;
  std::string device_name;  ///< for messages
  std::string identity;     ///< platform, device and driver with their versions: what a binary is good for
};

/// Compiles. Throws Error(kDevice) with the options and the compiler's log.
[[nodiscard]] Program built_from_source(const ProgramTarget& target, const char* source, const std::string& options);

/// The kernels, from `cache` (null: none) where it has them and the driver takes them, else compiled, and kept there.
[[nodiscard]] Program built_kernels(const ProgramTarget& target, const KernelParameters& parameters,
                                    const ProgramCache* cache);

}  // namespace cylpose::opencl
