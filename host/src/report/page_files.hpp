// The files a report is made of, embedded at build time (cmake/embed_files.cmake).
#pragma once

#include <string>

namespace cylpose::report_files {

[[nodiscard]] std::string base_html();     ///< of any page
[[nodiscard]] std::string page_html();     ///< sections of a run
[[nodiscard]] std::string scripts_html();  ///< its scripts
[[nodiscard]] std::string page_css();      ///< colours, text, tables: of any page
[[nodiscard]] std::string plots_css();     ///< plots that zoom, and how they print
[[nodiscard]] std::string charts_js();
[[nodiscard]] std::string page_js();
[[nodiscard]] std::string chart_library_js();  ///< dygraphs, minified
[[nodiscard]] std::string chart_library_licence();

}  // namespace cylpose::report_files
