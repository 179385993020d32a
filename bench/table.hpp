// A run as text to read.
#pragma once

#include <string>

#include "results.hpp"

namespace cylpose::bench {

/// Medians of all benchmarks, how many times longer the others took than `opencl`, and the time in which this machine
/// could just read the pixels.
[[nodiscard]] std::string table_of(const BenchRun& run);

}  // namespace cylpose::bench
