// What every fuzz target checks: a reader either gives something valid or refuses with Error(kInput) and a reason.
// Anything else that is thrown ends the process, which the fuzzer reports together with the input.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cylpose/error.hpp>
#include <string>
#include <string_view>

namespace cylpose::fuzz {

inline void require(bool holds, const char* what) {
  if (holds) return;
  std::fprintf(stderr, "does not hold: %s\n", what);
  std::abort();
}

inline std::string text_of(const std::uint8_t* data, std::size_t size) {
  return {reinterpret_cast<const char*>(data), size};
}

template <typename Read>
void read_or_refuse(Read read) {
  try {
    read();
  } catch (const Error& error) {
    require(error.kind() == ErrorKind::kInput, "a refusal is an input error");
    // Every reader is given the name "file".
    require(std::string_view(error.what()).starts_with("file:"), "a refusal names the file");
  }
}

}  // namespace cylpose::fuzz
