#include "help_text.hpp"

#include <fmt/format.h>

#include <array>
#include <cstddef>
#include <sstream>
#include <utility>

#include "commands.hpp"

namespace cylpose::apps {
namespace {

constexpr std::size_t kNameColumns = 30;
constexpr std::size_t kTextColumns = 70;
constexpr std::string_view kExamplesHeading = "Examples:\n";
constexpr std::string_view kExampleIndent = "  ";

std::string wrapped(const std::string& text) {
  std::istringstream words(text);
  std::string lines;
  std::size_t columns = 0;
  for (std::string word; words >> word; columns += word.size()) {
    if (columns > 0) {
      const bool fits = columns + 1 + word.size() <= kTextColumns;
      lines += fits ? ' ' : '\n';
      columns = fits ? columns + 1 : 0;
    }
    lines += word;
  }
  return lines;
}

}  // namespace

std::span<const ExitCodeText> exit_code_texts() {
  static constexpr std::array kTexts = {
      ExitCodeText{kSuccess, "success"},
      ExitCodeText{kInternalError, "internal error"},
      ExitCodeText{kInputError, "usage, or an input that cannot be used"},
      ExitCodeText{kOutputError, "an output that cannot be written"},
      ExitCodeText{kDeviceError, "a camera, device or server that is missing or failed"},
      ExitCodeText{kInterrupted, "interrupted; what was written stays"},
  };
  return kTexts;
}

std::string exit_codes_line() {
  std::string text = "Exit codes:\n";
  for (const ExitCodeText& entry : exit_code_texts()) text += fmt::format("  {:>3}  {}\n", entry.code, entry.meaning);
  text.pop_back();
  return text;
}

void set_examples(CLI::App& command, const std::vector<std::string>& lines) {
  std::string text(kExamplesHeading);
  for (const std::string& line : lines) text += fmt::format("{}{}\n", kExampleIndent, line);
  command.footer(text + "\n" + exit_codes_line());
}

std::vector<std::string> examples_of(const CLI::App& command) {
  std::vector<std::string> lines;
  std::istringstream footer(command.get_footer());
  std::string line;
  if (!std::getline(footer, line) || line + "\n" != kExamplesHeading) return lines;
  while (std::getline(footer, line) && line.starts_with(kExampleIndent)) {
    lines.push_back(line.substr(kExampleIndent.size()));
  }
  return lines;
}

std::string description_of(const CLI::Option& option) {
  std::string text = option.get_description();
  if (option.get_required()) text += " (required)";
  for (const CLI::Option* other : option.get_needs()) text += fmt::format(" (only with {})", other->get_name());
  return text;
}

HelpFormatter::HelpFormatter() {
  column_width(kNameColumns);
}

std::string HelpFormatter::make_help(const CLI::App* app, std::string name, CLI::AppFormatMode mode) const {
  return CLI::detail::find_and_replace(CLI::Formatter::make_help(app, std::move(name), mode), "\n\n\n", "\n\n");
}

std::string HelpFormatter::make_option_opts(const CLI::Option* option) const {
  // Of a positional argument the name says it.
  return option->get_positional() || option->get_items_expected_max() == 0 ? "" : " " + option->get_type_name();
}

std::string HelpFormatter::make_option_desc(const CLI::Option* option) const {
  return wrapped(description_of(*option));
}

std::string HelpFormatter::make_subcommand(const CLI::App* command) const {
  std::ostringstream text;
  CLI::detail::format_help(text, command->get_name(), wrapped(command->get_description()), kNameColumns);
  return text.str();
}

}  // namespace cylpose::apps
