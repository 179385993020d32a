#include <fmt/format.h>

#include <cylpose/html_page.hpp>
#include <cylpose/version.hpp>
#include <nlohmann/json.hpp>

#include "page_files.hpp"
#include "template.hpp"

namespace cylpose {
namespace {

std::string facts_html(const std::vector<ReportFact>& facts) {
  if (facts.empty()) return {};
  std::string html = "<ul class=\"facts\">\n";
  for (const ReportFact& fact : facts) {
    html += fmt::format("<li><span>{}:</span> {}</li>\n", html_escaped(fact.label), html_escaped(fact.value));
  }
  return html + "</ul>\n";
}

/// Bytes that are not UTF-8 become U+FFFD.
std::string valid_utf8(const std::string& text) {
  return nlohmann::json::parse(nlohmann::json(text).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace))
      .get<std::string>();
}

}  // namespace

std::string to_html(const HtmlPage& page) {
  return filled(report_files::base_html(), {{"title", html_escaped(page.title)},
                                            {"generator", std::string("cylpose ") + kVersion},
                                            {"css", report_files::page_css() + page.css},
                                            {"facts", facts_html(page.facts)},
                                            {"main", page.main},
                                            {"footer", page.footer},
                                            {"scripts", page.scripts}});
}

std::string filled(std::string_view text, std::initializer_list<Field> fields) {
  std::string result;
  for (std::size_t open = 0; (open = text.find("{{")) != std::string_view::npos;) {
    const std::size_t close = text.find("}}", open);
    const std::string_view name = text.substr(open + 2, close - open - 2);
    result += text.substr(0, open);
    for (const auto& [field, value] : fields) {
      if (field == name) result += value;
    }
    text.remove_prefix(close + 2);
  }
  return result += text;
}

std::string html_escaped(const std::string& text) {
  std::string result;
  for (const char c : valid_utf8(text)) {
    const auto code = static_cast<unsigned char>(c);
    if (c == '&') {
      result += "&amp;";
    } else if (c == '<') {
      result += "&lt;";
    } else if (c == '>') {
      result += "&gt;";
    } else if (c == '"') {
      result += "&quot;";
    } else if (code < 0x20 || code == 0x7F) {
      result += "\xEF\xBF\xBD";
    } else {
      result += c;
    }
  }
  return result;
}

std::string html_table(const std::string& caption, const std::string& head, const std::string& body) {
  return fmt::format(
      "<div class=\"scroll\" tabindex=\"0\" role=\"region\" aria-label=\"{0}\">\n<table>\n<caption>{0}</caption>\n"
      "<thead>\n{1}</thead>\n<tbody>\n{2}</tbody>\n</table>\n</div>\n",
      caption, head, body);
}

std::string html_data_block(std::string json) {
  // "</script>" and "<!--" end or change a script element.
  for (std::size_t at = 0; (at = json.find('<', at)) != std::string::npos;) json.replace(at, 1, "\\u003c");
  return "<script id=\"data\" type=\"application/json\">" + json + "</script>\n";
}

}  // namespace cylpose
