#include "opencl/program_cache.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <atomic>
#include <cstdint>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <string_view>
#include <system_error>

namespace cylpose::opencl {
namespace {

// An entry: this line, the lengths of key and binary and the binary's checksum in a line, key, binary.
constexpr std::string_view kMagic = "cylpose program 1\n";

// FNV-1a: tells a damaged file, and names files.
std::uint64_t checksum(const unsigned char* data, std::size_t size) {
  std::uint64_t hash = 14695981039346656037U;
  for (std::size_t i = 0; i < size; ++i) hash = (hash ^ data[i]) * 1099511628211U;
  return hash;
}

std::string header_of(const std::string& key, const std::vector<unsigned char>& binary) {
  return fmt::format("{}{} {} {:016x}\n{}", kMagic, key.size(), binary.size(), checksum(binary.data(), binary.size()),
                     key);
}

}  // namespace

std::filesystem::path ProgramCache::path_of(const std::string& key) const {
  std::vector<unsigned char> bytes(key.begin(), key.end());
  return folder_ / fmt::format("{:016x}.clbin", checksum(bytes.data(), bytes.size()));
}

std::optional<std::vector<unsigned char>> ProgramCache::find(const std::string& key) const {
  std::ifstream file(path_of(key), std::ios::binary);
  const std::string content((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
  if (!file || content.size() < kMagic.size()) return std::nullopt;
  const std::size_t end_of_numbers = content.find('\n', kMagic.size());
  if (end_of_numbers == std::string::npos) return std::nullopt;
  const std::size_t binary_at = end_of_numbers + 1 + key.size();
  if (content.size() <= binary_at) return std::nullopt;
  const auto first = content.begin() + static_cast<std::ptrdiff_t>(binary_at);
  std::vector<unsigned char> binary(first, content.end());
  if (std::string_view(content).substr(0, binary_at) != header_of(key, binary)) return std::nullopt;
  return binary;
}

void ProgramCache::store(const std::string& key, const std::vector<unsigned char>& binary) const {
  static std::atomic<unsigned> serial = 0;
  std::error_code ignored;
  std::filesystem::create_directories(folder_, ignored);
  const std::filesystem::path path = path_of(key);
  std::filesystem::path unfinished = path;
  unfinished += fmt::format(".{}.{}", ::getpid(), serial++);
  bool complete = false;
  {
    std::ofstream file(unfinished, std::ios::binary);
    file << header_of(key, binary);
    file.write(reinterpret_cast<const char*>(binary.data()), static_cast<std::streamsize>(binary.size()));
    file.close();
    complete = !file.fail();
  }
  if (complete) std::filesystem::rename(unfinished, path, ignored);
  if (!complete || ignored) std::filesystem::remove(unfinished, ignored);
}

std::filesystem::path default_cache_folder() {
  const auto folder_in = [](const char* variable) -> std::filesystem::path {
    const char* value = std::getenv(variable);
    // The XDG specification ignores relative paths.
    return value != nullptr && std::filesystem::path(value).is_absolute() ? value : "";
  };
  if (const auto cache = folder_in("XDG_CACHE_HOME"); !cache.empty()) return cache / "cylpose";
  if (const auto home = folder_in("HOME"); !home.empty()) return home / ".cache" / "cylpose";
  return {};
}

}  // namespace cylpose::opencl
