#include "text_file.hpp"

#include <fmt/format.h>

#include <cerrno>
#include <charconv>
#include <cstring>
#include <cylpose/error.hpp>
#include <fstream>

namespace cylpose {
namespace {

namespace fs = std::filesystem;

template <typename Number>
std::optional<Number> parse_whole(std::string_view text) {
  text = trimmed(text);
  // from_chars takes no plus sign, people and printf("%+g") write it.
  if (text.starts_with('+') && !text.starts_with("+-")) text.remove_prefix(1);
  Number number{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return number;
}

}  // namespace

std::string read_file(const fs::path& path, std::size_t max_bytes) {
  std::error_code ignored;
  if (!fs::exists(path, ignored)) {
    throw Error(ErrorKind::kInput, fmt::format("{}: no such file; check the path", path.string()));
  }
  if (fs::is_directory(path, ignored)) {
    throw Error(ErrorKind::kInput, fmt::format("{}: is a folder; give a file", path.string()));
  }
  errno = 0;
  std::ifstream file(path, std::ios::binary);
  if (!file) {
    throw Error(ErrorKind::kInput, fmt::format("{}: cannot be read: {}", path.string(), std::strerror(errno)));
  }
  // Read in pieces rather than ask for the size: pipes and /dev/fd files have none.
  std::string text;
  char piece[65536];
  while (file.read(piece, sizeof piece), file.gcount() > 0) {
    text.append(piece, static_cast<std::size_t>(file.gcount()));
    if (text.size() > max_bytes) {
      throw Error(ErrorKind::kInput,
                  fmt::format("{}: is larger than {} bytes; is it the right file?", path.string(), max_bytes));
    }
  }
  if (file.bad()) {
    throw Error(ErrorKind::kInput, fmt::format("{}: cannot be read: {}", path.string(), std::strerror(errno)));
  }
  if (trimmed(text).empty()) {
    throw Error(ErrorKind::kInput, fmt::format("{}: is empty; was it written completely?", path.string()));
  }
  return text;
}

void write_file(const fs::path& path, std::string_view text) {
  errno = 0;
  std::ofstream file(path, std::ios::binary | std::ios::trunc);
  file.write(text.data(), static_cast<std::streamsize>(text.size()));
  file.close();
  if (!file) {
    throw Error(ErrorKind::kOutput, fmt::format("{}: cannot be written: {}; choose a place that exists, is writable "
                                                "and has room",
                                                path.string(), std::strerror(errno)));
  }
}

std::optional<double> parse_number(std::string_view text) {
  return parse_whole<double>(text);
}

std::optional<long long> parse_integer(std::string_view text) {
  return parse_whole<long long>(text);
}

std::string_view trimmed(std::string_view text) {
  constexpr std::string_view kBlanks = " \t\r\n";
  const std::size_t first = text.find_first_not_of(kBlanks);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(kBlanks) - first + 1);
}

}  // namespace cylpose
