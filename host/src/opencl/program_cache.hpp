// Built programs on disk, so that only the first process on a machine compiles them.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace cylpose::opencl {

/// A folder of binaries, each found by the full text of its key. Whatever goes wrong here only costs time: a file that
/// cannot be read, is damaged or has another key is no entry, one that cannot be written is not kept.
class ProgramCache {
 public:
  explicit ProgramCache(std::filesystem::path folder) : folder_(std::move(folder)) {}

  [[nodiscard]] std::optional<std::vector<unsigned char>> find(const std::string& key) const;

  /// Other processes see the whole entry or none.
  void store(const std::string& key, const std::vector<unsigned char>& binary) const;

 private:
  [[nodiscard]] std::filesystem::path path_of(const std::string& key) const;

  std::filesystem::path folder_;
};

/// cylpose/ in $XDG_CACHE_HOME, else in ~/.cache; empty where neither is known.
[[nodiscard]] std::filesystem::path default_cache_folder();

}  // namespace cylpose::opencl
