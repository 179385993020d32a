#include "output.hpp"

#include <fmt/format.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <cylpose/error.hpp>
#include <memory>

namespace cylpose::apps {
namespace {

[[noreturn]] void fail(const std::string& name) {
  throw Error(ErrorKind::kOutput, fmt::format("{}: cannot be written: {}; choose a place that exists, is writable and "
                                              "has room",
                                              name, std::strerror(errno)));
}

}  // namespace

void write_stdout(std::string_view text) {
  if (std::fwrite(text.data(), 1, text.size(), stdout) != text.size() || std::fflush(stdout) != 0) {
    fail("standard output");
  }
}

void write_result(const std::string& destination, std::string_view text) {
  if (destination == "-") return write_stdout(text);
  std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(std::fopen(destination.c_str(), "wb"), std::fclose);
  if (!file || std::fwrite(text.data(), 1, text.size(), file.get()) != text.size() || std::fflush(file.get()) != 0) {
    fail(destination);
  }
}

}  // namespace cylpose::apps
