// Pages that need nothing but a browser: what the reports of runs and of the bench have in common.
#pragma once

#include <string>
#include <vector>

namespace cylpose {

/// What was run, and on what; shown at the head of a page.
struct ReportFact {
  std::string label;
  std::string value;
};

/// `title` and `facts` may hold any text; the rest is HTML, CSS and elements of scripts as they are.
struct HtmlPage {
  std::string title;
  std::vector<ReportFact> facts;
  std::string css;      ///< besides the style of all pages
  std::string main;     ///< sections
  std::string footer;   ///< after who made it
  std::string scripts;  ///< at the end
};

/// The page, valid HTML 5 in UTF-8 if its pieces are: it asks the network for nothing (its content security policy
/// forbids it), follows the reader's light or dark colours and prints.
[[nodiscard]] std::string to_html(const HtmlPage& page);

/// Text for HTML, as content and inside quoted attributes: bytes that are not UTF-8 and control characters become
/// U+FFFD.
[[nodiscard]] std::string html_escaped(const std::string& text);

/// `head` and `body` are rows. The frame scrolls where the table is wider than the screen, also by keyboard.
[[nodiscard]] std::string html_table(const std::string& caption, const std::string& head, const std::string& body);

/// `<script id="data">` with JSON, whatever the texts in it are.
[[nodiscard]] std::string html_data_block(std::string json);

}  // namespace cylpose
