// The files a report is made of, embedded at build time (cmake/embed_files.cmake).
#pragma once

#include <string>

namespace cylpose::report_files {

[[nodiscard]] std::string page_html();
[[nodiscard]] std::string page_css();
[[nodiscard]] std::string charts_js();
[[nodiscard]] std::string page_js();
[[nodiscard]] std::string chart_library_js();  ///< dygraphs, minified
[[nodiscard]] std::string chart_library_licence();

}  // namespace cylpose::report_files
