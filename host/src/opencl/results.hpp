// From what the kernels leave to an EdgeField.
#pragma once

#include <cylpose/edge_field.hpp>

#include "opencl/strip_run.hpp"

namespace cylpose::opencl {

/// Statistics, edges and (on request) masks of all parts, from a run over all rows.
void collect(const StripRun& run, const StripTask& task, EdgeField& field);

}  // namespace cylpose::opencl
