#include <cylpose/report.hpp>
#include <cylpose/version.hpp>
#include <initializer_list>
#include <string_view>
#include <utility>

#include "data_block.hpp"
#include "page_files.hpp"
#include "series.hpp"
#include "tables.hpp"

namespace cylpose {
namespace {

using Field = std::pair<std::string_view, std::string>;

/// `page` with each `{{name}}` replaced by its field; what stands in the fields is not looked at.
std::string filled(std::string_view page, std::initializer_list<Field> fields) {
  std::string text;
  for (std::size_t open = 0; (open = page.find("{{")) != std::string_view::npos;) {
    const std::size_t close = page.find("}}", open);
    const std::string_view name = page.substr(open + 2, close - open - 2);
    text += page.substr(0, open);
    for (const auto& [field, value] : fields) {
      if (field == name) text += value;
    }
    page.remove_prefix(close + 2);
  }
  return text += page;
}

std::string sections_html(const RunSeries& run) {
  std::string html;
  for (std::size_t i = 0; i < run.parts.size(); ++i) {
    html += filled(
        "<section aria-labelledby=\"part-{{i}}\">\n<h2 id=\"part-{{i}}\">{{name}}</h2>\n"
        "<div class=\"charts\" data-part=\"{{i}}\"></div>\n{{tables}}</section>\n",
        {{"i", std::to_string(i)}, {"name", escaped(run.parts[i].name)}, {"tables", part_html(run.parts[i])}});
  }
  return html;
}

std::string optional_section(const std::string& title, const std::string& content) {
  return content.empty() ? content : "<section>\n<h2>" + title + "</h2>\n" + content + "</section>\n";
}

}  // namespace

std::string to_html(const Report& report) {
  const RunSeries run = series_of(report);
  const std::string pictures = pictures_html(report.pictures);
  const std::string frame_times =
      report.frame_times.empty() ? std::string() : "<div class=\"charts\" data-times></div>\n";
  return filled(report_files::page_html(),
                {{"title", escaped(report.title)},
                 {"generator", std::string("cylpose ") + kVersion},
                 {"css", report_files::page_css()},
                 {"facts", facts_html(report.facts)},
                 {"summary", summary_html(run)},
                 {"parts", sections_html(run)},
                 {"pictures",
                  optional_section("Best and worst frames",
                                   pictures.empty() ? pictures : "<div class=\"pictures\">\n" + pictures + "</div>\n")},
                 {"stages", optional_section("Time per stage", frame_times + stages_html(report.stages))},
                 {"data", data_block(report, run)},
                 {"chart_library_licence", report_files::chart_library_licence()},
                 {"chart_library", report_files::chart_library_js()},
                 {"charts", report_files::charts_js()},
                 {"script", report_files::page_js()}});
}

}  // namespace cylpose
