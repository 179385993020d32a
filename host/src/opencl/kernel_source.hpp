// The text of all kernels, embedded at build time (cmake/embed_kernels.cmake).
#pragma once

namespace cylpose::opencl {

[[nodiscard]] const char* kernel_source();
[[nodiscard]] const char* kernel_hash();  ///< SHA-256 of kernel_source(), hexadecimal

}  // namespace cylpose::opencl
