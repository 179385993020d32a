#include "manual_page.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <cylpose/version.hpp>
#include <string_view>
#include <vector>

#include "help_text.hpp"
#include "option_value.hpp"

namespace cylpose::apps {
namespace {

/// Text that roff prints as it stands; what is in `backticks` becomes bold.
std::string roff(std::string_view text) {
  std::string escaped;
  bool bold = false;
  for (const char c : text) {
    switch (c) {
      case '\\':
        escaped += "\\e";
        break;
      case '-':
        escaped += "\\-";
        break;
      case '`':
        bold = !bold;
        escaped += bold ? "\\fB" : "\\fP";
        break;
      default:
        // A dot or an apostrophe at the start of a line would be a request.
        if ((c == '.' || c == '\'') && escaped.empty()) escaped += "\\&";
        escaped += c;
    }
  }
  return escaped;
}

std::string upper(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) { return std::toupper(c); });
  return text;
}

/// A description as the name section wants it: no capital, no full stop.
std::string one_line(std::string text) {
  if (text.size() > 1 && std::islower(static_cast<unsigned char>(text[1])) != 0) {
    text[0] = static_cast<char>(std::tolower(static_cast<unsigned char>(text[0])));
  }
  if (text.ends_with('.')) text.pop_back();
  return text;
}

std::string header(const std::string& name, const std::string& description) {
  return fmt::format(
      ".\\\" Made from the option tables of cylpose {0}; changes belong there.\n"
      ".TH {1} 1 \"\" \"cylpose {0}\" \"User Commands\"\n.SH NAME\n{2} \\- {3}\n",
      kVersion, upper(name), roff(name), roff(one_line(description)));
}

std::string positional_usage(const CLI::Option& option) {
  const std::string name = upper(option.get_name(true, false));
  const std::string all = option.get_expected_max() > 1 ? name + "..." : name;
  return option.get_required() ? fmt::format("\\fI{}\\fP", roff(all)) : fmt::format("[\\fI{}\\fP]", roff(all));
}

std::string synopsis(const CLI::App& command) {
  std::string text = fmt::format(".SH SYNOPSIS\n\\fBcylpose {}\\fP", roff(command.get_name()));
  for (const CLI::Option* option : named_options(command)) {
    if (!option->get_required()) continue;
    text += fmt::format(" \\fB{}\\fP \\fI{}\\fP", roff(dashed_names(*option).back()), roff(option->get_type_name()));
  }
  text += " [\\fIOPTION\\fP]...";
  for (const CLI::Option* option : positionals(command)) text += " " + positional_usage(*option);
  return text + "\n";
}

std::string entry(const CLI::Option& option) {
  std::string names;
  for (const std::string& name : dashed_names(option)) {
    names += fmt::format("{}\\fB{}\\fP", names.empty() ? "" : ", ", roff(name));
  }
  if (option.get_items_expected_max() > 0) names += fmt::format(" \\fI{}\\fP", roff(option.get_type_name()));
  return fmt::format(".TP\n{}\n{}\n", names, roff(description_of(option)));
}

std::string argument_entries(const CLI::App& command) {
  std::string text;
  for (const CLI::Option* option : positionals(command)) {
    text +=
        fmt::format(".TP\n\\fI{}\\fP\n{}\n", roff(upper(option->get_name(true, false))), roff(description_of(*option)));
  }
  return text.empty() ? "" : ".SH ARGUMENTS\n" + text;
}

std::string option_entries(const CLI::App& command) {
  std::string text = ".SH OPTIONS\n";
  for (const CLI::Option* option : named_options(command)) text += entry(*option);
  return text;
}

std::string examples(const CLI::App& command) {
  const std::vector<std::string> lines = examples_of(command);
  if (lines.empty()) return "";
  std::string text = ".SH EXAMPLES\n.nf\n";
  for (const std::string& line : lines) text += roff(line) + "\n";
  return text + ".fi\n";
}

std::string exit_status() {
  std::string text = ".SH EXIT STATUS\n";
  for (const ExitCodeText& status : exit_code_texts()) {
    text += fmt::format(".TP\n{}\n{}\n", status.code, roff(status.meaning));
  }
  return text;
}

std::string see_also(const CLI::App& app, const CLI::App* here) {
  std::vector<std::string> pages;
  if (here != nullptr) pages.emplace_back("\\fBcylpose\\fP(1)");
  for (const CLI::App* command : visible_commands(app)) {
    if (command != here) pages.push_back(fmt::format("\\fBcylpose\\-{}\\fP(1)", roff(command->get_name())));
  }
  return fmt::format(".SH SEE ALSO\n{}\n", fmt::join(pages, ",\n"));
}

}  // namespace

std::string manual_page(const CLI::App& app) {
  const std::string& name = app.get_name();
  std::string description = app.get_description();
  if (description.starts_with(name + ": ")) description.erase(0, name.size() + 2);
  std::string text = header(name, description) +
                     ".SH SYNOPSIS\n\\fBcylpose\\fP \\fICOMMAND\\fP [\\fIOPTION\\fP]... [\\fIARGUMENT\\fP]...\n"
                     ".SH COMMANDS\n";
  for (const CLI::App* command : visible_commands(app)) {
    text += fmt::format(".TP\n\\fB{}\\fP\n{}\n", roff(command->get_name()), roff(command->get_description()));
  }
  return text + option_entries(app) + exit_status() + see_also(app, nullptr);
}

std::string manual_page(const CLI::App& app, const CLI::App& command) {
  return header(app.get_name() + "-" + command.get_name(), command.get_description()) + synopsis(command) +
         argument_entries(command) + option_entries(command) + examples(command) + exit_status() +
         see_also(app, &command);
}

}  // namespace cylpose::apps
