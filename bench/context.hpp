// On what, and with what, was measured.
#pragma once

namespace cylpose::bench {

/// Adds processor, versions, thread counts and devices to what a run prints and writes.
void describe_machine();

}  // namespace cylpose::bench
