// Text that a command writes as its result.
#pragma once

#include <string>
#include <string_view>

namespace cylpose::apps {

/// Writes to standard output. Throws Error(kOutput) when that is closed or full: a result that nobody got is no
/// success.
void write_stdout(std::string_view text);

/// Replaces a file, or writes to standard output for "-". Throws Error(kOutput) that names the path.
void write_result(const std::string& destination, std::string_view text);

}  // namespace cylpose::apps
