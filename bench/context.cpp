#include "context.hpp"

#include <benchmark/benchmark.h>
#include <fmt/format.h>
#include <sys/utsname.h>

#include <cstdlib>
#include <cylpose/opencl_devices.hpp>
#include <cylpose/version.hpp>
#include <fstream>
#include <opencv2/core.hpp>
#include <sstream>
#include <string>
#include <string_view>
#include <thread>

namespace cylpose::bench {
namespace {

// What follows the colon in the line whose first word or words are `key`; "unknown" where there is none.
std::string value_in(std::istream& lines, std::string_view key) {
  for (std::string line; std::getline(lines, line);) {
    const std::size_t first = line.find_first_not_of(" \t");
    const std::size_t colon = line.find(':');
    if (first == std::string::npos || colon == std::string::npos || line.compare(first, key.size(), key) != 0) continue;
    const std::size_t value = line.find_first_not_of(" \t", colon + 1);
    return value == std::string::npos ? "unknown" : line.substr(value);
  }
  return "unknown";
}

std::string processor() {
  std::ifstream file("/proc/cpuinfo");
  return value_in(file, "model name");
}

std::string opencv() {
  std::istringstream information(cv::getBuildInformation());
  return fmt::format("{}, {} threads ({}), optimised: {}", CV_VERSION, cv::getNumThreads(),
                     value_in(information, "Parallel framework"), cv::useOptimized() ? "yes" : "no");
}

std::string system_name() {
  utsname name{};
  return ::uname(&name) == 0 ? fmt::format("{} {} {}", name.sysname, name.release, name.machine) : "unknown";
}

}  // namespace

void describe_machine() {
  benchmark::AddCustomContext("cylpose", kVersion);
  benchmark::AddCustomContext("processor", processor());
  benchmark::AddCustomContext("threads", std::to_string(std::thread::hardware_concurrency()));
  benchmark::AddCustomContext("system", system_name());
  benchmark::AddCustomContext("compiler", CYLPOSE_BENCH_COMPILER);
  benchmark::AddCustomContext("build_type", CYLPOSE_BENCH_BUILD_TYPE);
  benchmark::AddCustomContext("opencv", opencv());
  for (const OpenclDevice& device : opencl_devices()) {
    benchmark::AddCustomContext(fmt::format("opencl_device_{}", device.index),
                                fmt::format("{} ({}, {}), {} compute units", device.name, device.platform,
                                            device.driver_version, device.compute_units));
  }
  if (const char* wanted = std::getenv("CYLPOSE_DEVICE"); wanted != nullptr) {
    benchmark::AddCustomContext("CYLPOSE_DEVICE", wanted);
  }
}

}  // namespace cylpose::bench
