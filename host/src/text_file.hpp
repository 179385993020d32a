// Whole files, and the numbers in text, independent of the locale.
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

namespace cylpose {

/// The file's bytes. Throws Error(kInput) that names the path when it is missing, a folder, unreadable, empty or larger
/// than `max_bytes` (a video given in place of a text file must not be read whole).
[[nodiscard]] std::string read_file(const std::filesystem::path& path, std::size_t max_bytes);

/// Replaces the file. Throws Error(kOutput) that names the path and the system's reason.
void write_file(const std::filesystem::path& path, std::string_view text);

/// The whole of `text` (blanks around it allowed) as a number; "nan" and "inf" are numbers here, the caller decides.
[[nodiscard]] std::optional<double> parse_number(std::string_view text);

/// The whole of `text` (blanks around it allowed) as a decimal integer.
[[nodiscard]] std::optional<long long> parse_integer(std::string_view text);

/// `text` without blanks, tabs and carriage returns around it.
[[nodiscard]] std::string_view trimmed(std::string_view text);

}  // namespace cylpose
