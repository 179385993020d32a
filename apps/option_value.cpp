#include "option_value.hpp"

#include <algorithm>
#include <cctype>
#include <cylpose/scenario.hpp>
#include <string_view>

namespace cylpose::apps {
namespace {

bool is_word(std::string_view text) {
  return !text.empty() && std::all_of(text.begin(), text.end(),
                                      [](unsigned char c) { return std::islower(c) != 0 || std::isdigit(c) != 0; });
}

bool is_file(std::string_view text) {
  return text == "FILE" || text.find('.') != std::string_view::npos;
}

}  // namespace

OptionValue value_of(const CLI::Option& option) {
  using Kind = OptionValue::Kind;
  if (option.get_items_expected_max() == 0) return {};
  const std::string type = option.get_type_name();
  if (option.get_name(true, false) == "SCENARIO") {
    OptionValue value{Kind::kWords, {}};
    for (const Scenario& scenario : scenarios()) value.words.push_back(scenario.name);
    return value;
  }
  const std::vector<std::string> alternatives = CLI::detail::split(type, '|');
  if (std::any_of(alternatives.begin(), alternatives.end(), is_file)) return {Kind::kFile, {}};
  if (std::find(alternatives.begin(), alternatives.end(), "DIR") != alternatives.end()) return {Kind::kFolder, {}};
  if (std::all_of(alternatives.begin(), alternatives.end(), is_word)) return {Kind::kWords, alternatives};
  return {Kind::kFree, {}};
}

std::vector<const CLI::Option*> named_options(const CLI::App& command) {
  return command.get_options(
      [](const CLI::Option* option) { return option->nonpositional() && !option->get_group().empty(); });
}

std::vector<const CLI::Option*> positionals(const CLI::App& command) {
  return command.get_options([](const CLI::Option* option) { return option->get_positional(); });
}

std::vector<const CLI::App*> visible_commands(const CLI::App& app) {
  return app.get_subcommands([](const CLI::App* command) { return !command->get_group().empty(); });
}

std::vector<std::string> dashed_names(const CLI::Option& option) {
  std::vector<std::string> names;
  for (const std::string& name : option.get_snames()) names.push_back("-" + name);
  for (const std::string& name : option.get_lnames()) names.push_back("--" + name);
  return names;
}

}  // namespace cylpose::apps
