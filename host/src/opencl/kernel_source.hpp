// The text of all kernels, embedded at build time (cmake/embed_kernels.cmake).
#pragma once

namespace cylpose::opencl {

extern const char* const kKernelSource;
extern const char* const kKernelHash;  ///< SHA-256 of kKernelSource, hexadecimal

}  // namespace cylpose::opencl
