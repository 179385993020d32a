#include <cylpose/html_page.hpp>
#include <cylpose/report.hpp>

#include "data_block.hpp"
#include "page_files.hpp"
#include "series.hpp"
#include "tables.hpp"
#include "template.hpp"

namespace cylpose {
namespace {

std::string sections_html(const RunSeries& run) {
  std::string html;
  for (std::size_t i = 0; i < run.parts.size(); ++i) {
    html += filled(
        "<section aria-labelledby=\"part-{{i}}\">\n<h2 id=\"part-{{i}}\">{{name}}</h2>\n"
        "<div class=\"charts\" data-part=\"{{i}}\"></div>\n{{tables}}</section>\n",
        {{"i", std::to_string(i)}, {"name", html_escaped(run.parts[i].name)}, {"tables", part_html(run.parts[i])}});
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
  HtmlPage page;
  page.title = report.title;
  page.facts = report.facts;
  page.css = report_files::plots_css();
  page.main =
      filled(report_files::page_html(),
             {{"summary", summary_html(run)},
              {"parts", sections_html(run)},
              {"pictures",
               optional_section("Best and worst frames",
                                pictures.empty() ? pictures : "<div class=\"pictures\">\n" + pictures + "</div>\n")},
              {"stages", optional_section("Time per stage", frame_times + stages_html(report.stages))}});
  page.footer = "; plots by dygraphs (MIT licence, in this page's source).";
  page.scripts = data_block(report, run) +
                 filled(report_files::scripts_html(), {{"chart_library_licence", report_files::chart_library_licence()},
                                                       {"chart_library", report_files::chart_library_js()},
                                                       {"charts", report_files::charts_js()},
                                                       {"script", report_files::page_js()}});
  return to_html(page);
}

}  // namespace cylpose
