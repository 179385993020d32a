#include "opencl/program.hpp"

#include <fmt/format.h>

#include <cylpose/error.hpp>
#include <optional>
#include <vector>

#include "channels.hpp"
#include "opencl/kernel_source.hpp"

namespace cylpose::opencl {
namespace {

std::string build_log(const ProgramTarget& target, cl_program program) {
  std::size_t size = 0;
  if (clGetProgramBuildInfo(program, target.device, CL_PROGRAM_BUILD_LOG, 0, nullptr, &size) != CL_SUCCESS) return {};
  std::string log(size, '\0');
  if (clGetProgramBuildInfo(program, target.device, CL_PROGRAM_BUILD_LOG, size, log.data(), nullptr) != CL_SUCCESS) {
    return {};
  }
  return log.substr(0, log.find('\0'));
}

std::optional<Program> built_from_binary(const ProgramTarget& target, const std::vector<unsigned char>& binary,
                                         const std::string& options) {
  const unsigned char* data = binary.data();
  const std::size_t size = binary.size();
  cl_int status = CL_SUCCESS;
  cl_int code = CL_SUCCESS;
  Program program(clCreateProgramWithBinary(target.context, 1, &target.device, &size, &data, &status, &code));
  if (code != CL_SUCCESS || status != CL_SUCCESS) return std::nullopt;
  code = clBuildProgram(program.get(), 1, &target.device, options.c_str(), nullptr, nullptr);
  if (code != CL_SUCCESS) return std::nullopt;
  return program;
}

// Empty where the driver does not give it away.
std::vector<unsigned char> binary_of(cl_program program) {
  std::size_t size = 0;
  if (clGetProgramInfo(program, CL_PROGRAM_BINARY_SIZES, sizeof size, &size, nullptr) != CL_SUCCESS) return {};
  std::vector<unsigned char> binary(size);
  unsigned char* data = binary.data();
  if (clGetProgramInfo(program, CL_PROGRAM_BINARIES, sizeof(unsigned char*), &data, nullptr) != CL_SUCCESS) return {};
  return binary;
}

}  // namespace

std::string build_options(const KernelParameters& parameters) {
  const Channels channels = channels_of(parameters.format);
  std::string options = fmt::format("-cl-std=CL1.2 -DCYL_GROUP_SIZE={} -DCYL_SPAN_WORDS={} -DCYL_CHANNELS={}",
                                    parameters.group_size, parameters.span_words, channels.step);
  if (channels.step == 3) options += fmt::format(" -DCYL_RED={}", channels.red);
  return options;
}

Program built_from_source(const ProgramTarget& target, const char* source, const std::string& options) {
  cl_int code = CL_SUCCESS;
  Program program(clCreateProgramWithSource(target.context, 1, &source, nullptr, &code));
  check(code, "clCreateProgramWithSource", target.device_name);
  code = clBuildProgram(program.get(), 1, &target.device, options.c_str(), nullptr, nullptr);
  if (code != CL_SUCCESS) {
    throw Error(ErrorKind::kDevice,
                fmt::format("clBuildProgram failed with {} on {}; options: {}; log:\n{}", error_name(code),
                            target.device_name, options, build_log(target, program.get())));
  }
  return program;
}

Program built_kernels(const ProgramTarget& target, const KernelParameters& parameters, const ProgramCache* cache) {
  const std::string options = build_options(parameters);
  const std::string key = target.identity + "\n" + kernel_hash() + "\n" + options;
  if (cache != nullptr) {
    if (const auto binary = cache->find(key)) {
      if (auto program = built_from_binary(target, *binary, options)) return std::move(*program);
    }
  }
  Program program = built_from_source(target, kernel_source(), options);
  if (cache != nullptr) {
    if (const auto binary = binary_of(program.get()); !binary.empty()) cache->store(key, binary);
  }
  return program;
}

}  // namespace cylpose::opencl
