// The files of the live page, embedded at build time (cmake/embed_files.cmake).
#pragma once

#include <string>

namespace cylpose::apps::live_files {

[[nodiscard]] std::string page_html();
[[nodiscard]] std::string base_css();  ///< the report's colours, text and tables
[[nodiscard]] std::string page_css();
[[nodiscard]] std::string page_js();
[[nodiscard]] std::string icon_svg();

}  // namespace cylpose::apps::live_files
