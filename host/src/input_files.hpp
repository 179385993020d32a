// Which files the words on a command line mean.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace cylpose {

/// Natural order: runs of digits compare as numbers (frame_9 before frame_10), everything else byte by byte.
[[nodiscard]] bool natural_less(std::string_view a, std::string_view b);

/// The image files of a folder in natural order. Throws Error(kInput) when there are none.
[[nodiscard]] std::vector<std::filesystem::path> images_in_folder(const std::filesystem::path& folder);

/// True for a path whose last part holds one printf integer (%d, %4d, %04d).
[[nodiscard]] bool is_printf_pattern(const std::string& pattern);

/// The files that exist for a printf pattern, in the order of their numbers (gaps allowed). Throws Error(kInput) when
/// there are none.
[[nodiscard]] std::vector<std::filesystem::path> files_of_printf_pattern(const std::string& pattern);

/// True for a word with *, ? or [.
[[nodiscard]] bool is_glob(const std::string& pattern);

/// The paths that match a glob, in natural order. Throws Error(kInput) when there are none.
[[nodiscard]] std::vector<std::filesystem::path> files_of_glob(const std::string& pattern);

}  // namespace cylpose
