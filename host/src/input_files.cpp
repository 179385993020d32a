#include "input_files.hpp"

#include <fmt/format.h>
#include <glob.h>

#include <algorithm>
#include <cctype>
#include <cylpose/error.hpp>
#include <optional>
#include <utility>

#include "image_file.hpp"
#include "text_file.hpp"

namespace cylpose {
namespace {

namespace fs = std::filesystem;

bool is_digit(char c) {
  return c >= '0' && c <= '9';
}

/// The run of digits at `at`, without leading zeros.
std::string_view digits_at(std::string_view text, std::size_t at, std::size_t* end) {
  *end = at;
  while (*end < text.size() && is_digit(text[*end])) ++*end;
  while (at + 1 < *end && text[at] == '0') ++at;
  return text.substr(at, *end - at);
}

struct PrintfPattern {
  std::string before, after;
  std::size_t width = 0;  ///< least number of digits
  bool zero_padded = false;
};

std::optional<PrintfPattern> parsed(const std::string& name) {
  const std::size_t percent = name.find('%');
  if (percent == std::string::npos) return std::nullopt;
  PrintfPattern pattern{name.substr(0, percent), "", 0, false};
  std::size_t at = percent + 1;
  if (at < name.size() && name[at] == '0') {
    pattern.zero_padded = true;
    ++at;
  }
  while (at < name.size() && is_digit(name[at]) && pattern.width < 100) {
    pattern.width = pattern.width * 10 + static_cast<std::size_t>(name[at++] - '0');
  }
  if (at >= name.size() || (name[at] != 'd' && name[at] != 'i')) return std::nullopt;
  pattern.after = name.substr(at + 1);
  if (pattern.after.find('%') != std::string::npos) return std::nullopt;
  return pattern;
}

/// The number for which printf would have written `name`.
std::optional<long long> number_in(const PrintfPattern& pattern, std::string_view name) {
  if (name.size() <= pattern.before.size() + pattern.after.size() || !name.starts_with(pattern.before) ||
      !name.ends_with(pattern.after)) {
    return std::nullopt;
  }
  std::string_view middle = name.substr(pattern.before.size());
  middle.remove_suffix(pattern.after.size());
  if (middle.size() < pattern.width) return std::nullopt;
  const char padding = pattern.zero_padded ? '0' : ' ';
  const std::size_t size = middle.size();
  while (middle.size() > 1 && middle.front() == padding) middle.remove_prefix(1);
  const bool padded_too_far = middle.size() < size && size > std::max<std::size_t>(pattern.width, 1);
  if (padded_too_far || !std::all_of(middle.begin(), middle.end(), is_digit)) return std::nullopt;
  if (middle.size() > 1 && middle.front() == '0') return std::nullopt;
  return parse_integer(middle);
}

[[noreturn]] void fail_empty(const std::string& what, const char* message) {
  throw Error(ErrorKind::kInput, fmt::format("{}: {}", what, message));
}

}  // namespace

bool natural_less(std::string_view a, std::string_view b) {
  std::size_t i = 0;
  std::size_t j = 0;
  while (i < a.size() && j < b.size()) {
    if (is_digit(a[i]) && is_digit(b[j])) {
      const std::string_view number_a = digits_at(a, i, &i);
      const std::string_view number_b = digits_at(b, j, &j);
      if (number_a.size() != number_b.size()) return number_a.size() < number_b.size();
      if (number_a != number_b) return number_a < number_b;
    } else if (a[i] != b[j]) {
      return static_cast<unsigned char>(a[i]) < static_cast<unsigned char>(b[j]);
    } else {
      ++i;
      ++j;
    }
  }
  if (i < a.size() || j < b.size()) return j < b.size();
  return a < b;  // equal up to leading zeros
}

std::vector<fs::path> images_in_folder(const fs::path& folder) {
  std::vector<fs::path> files;
  std::error_code error;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error)) {
    if (has_image_extension(entry->path()) && !entry->is_directory()) files.push_back(entry->path());
  }
  if (error) throw Error(ErrorKind::kInput, fmt::format("{}: cannot be read: {}", folder.string(), error.message()));
  if (files.empty()) fail_empty(folder.string(), "no images in this folder");
  std::sort(files.begin(), files.end(),
            [](const fs::path& a, const fs::path& b) { return natural_less(a.native(), b.native()); });
  return files;
}

bool is_printf_pattern(const std::string& pattern) {
  return parsed(fs::path(pattern).filename().string()).has_value();
}

std::vector<fs::path> files_of_printf_pattern(const std::string& pattern) {
  const fs::path path(pattern);
  const std::optional<PrintfPattern> printf = parsed(path.filename().string());
  if (!printf) fail_empty(pattern, "is no pattern with one integer like frame_%04d.png");
  std::vector<std::pair<long long, fs::path>> files;
  std::error_code error;
  const fs::path folder = path.has_parent_path() ? path.parent_path() : fs::path(".");
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error)) {
    const fs::path name = entry->path().filename();
    if (const auto number = number_in(*printf, name.native())) files.emplace_back(*number, path.parent_path() / name);
  }
  if (files.empty()) fail_empty(pattern, "no file matches this pattern; check folder and number of digits");
  std::sort(files.begin(), files.end());
  std::vector<fs::path> sorted;
  sorted.reserve(files.size());
  for (auto& [number, file] : files) sorted.push_back(std::move(file));
  return sorted;
}

bool is_glob(const std::string& pattern) {
  return pattern.find_first_of("*?[") != std::string::npos;
}

std::vector<fs::path> files_of_glob(const std::string& pattern) {
  glob_t matches{};
  std::vector<fs::path> files;
  if (glob(pattern.c_str(), GLOB_NOSORT, nullptr, &matches) == 0) {
    files.assign(matches.gl_pathv, matches.gl_pathv + matches.gl_pathc);
  }
  globfree(&matches);
  if (files.empty()) fail_empty(pattern, "no file matches this pattern; check folder and spelling");
  std::sort(files.begin(), files.end(),
            [](const fs::path& a, const fs::path& b) { return natural_less(a.native(), b.native()); });
  return files;
}

}  // namespace cylpose
