// The bench page's own style, embedded at build time (cmake/embed_files.cmake).
#pragma once

#include <string>

namespace cylpose::bench::page_files {

[[nodiscard]] std::string page_css();

}  // namespace cylpose::bench::page_files
