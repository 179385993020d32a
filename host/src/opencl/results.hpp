// From what the kernels leave to an EdgeField.
#pragma once

#include <cylpose/edge_field.hpp>

#include "opencl/team.hpp"

namespace cylpose::opencl {

/// Statistics, edges, device times and (on request) masks of all parts, from strips that follow each other.
void collect(const std::vector<DoneStrip>& strips, EdgeField& field);

}  // namespace cylpose::opencl
