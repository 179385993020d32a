#include "completion.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <vector>

#include "option_value.hpp"

namespace cylpose::apps {
namespace {

constexpr const char* kScript = R"(# bash completion for cylpose, made from its option tables; changes belong there.

_cylpose_files() {{
  compopt -o filenames 2>/dev/null
  mapfile -t COMPREPLY < <(compgen "-$1" -- "$current")
}}

_cylpose_words() {{
  mapfile -t COMPREPLY < <(compgen -W "$1" -- "$current")
}}

_cylpose() {{
  local current=${{COMP_WORDS[COMP_CWORD]}} previous=${{COMP_WORDS[COMP_CWORD-1]}} command=${{COMP_WORDS[1]}}
  COMPREPLY=()
  if [ "$COMP_CWORD" -eq 1 ]; then
    _cylpose_words "{commands}"
    return
  fi
  # --option=value comes as three words.
  if [ "$current" = "=" ]; then
    current=
  elif [ "$previous" = "=" ]; then
    previous=${{COMP_WORDS[COMP_CWORD-2]}}
  fi
  case $command:$previous in
{values}  esac
  case $command:$current in
{names}{arguments}  esac
}}

complete -F _cylpose cylpose
)";

/// What the shell does to complete a value.
std::string action_of(const OptionValue& value) {
  switch (value.kind) {
    case OptionValue::Kind::kWords:
      return fmt::format("_cylpose_words \"{}\"", fmt::join(value.words, " "));
    case OptionValue::Kind::kFile:
      return "_cylpose_files f";
    case OptionValue::Kind::kFolder:
      return "_cylpose_files d";
    case OptionValue::Kind::kFree:  // nothing to suggest, and no option either
    case OptionValue::Kind::kNone:
      break;
  }
  return "";
}

}  // namespace

std::string bash_completion(const CLI::App& app) {
  std::vector<std::string> commands;
  std::string values, names, arguments;
  for (const CLI::App* command : visible_commands(app)) {
    commands.push_back(command->get_name());
    std::vector<std::string> dashed;
    for (const CLI::Option* option : named_options(*command)) {
      const OptionValue value = value_of(*option);
      std::vector<std::string> patterns = dashed_names(*option);
      dashed.insert(dashed.end(), patterns.begin(), patterns.end());
      if (value.kind == OptionValue::Kind::kNone) continue;
      for (std::string& pattern : patterns) pattern.insert(0, command->get_name() + ":");
      values += fmt::format("    {}) {}{}return ;;\n", fmt::join(patterns, " | "), action_of(value),
                            action_of(value).empty() ? "" : "; ");
    }
    names += fmt::format("    {}:-*) _cylpose_words \"{}\" ;;\n", command->get_name(), fmt::join(dashed, " "));
    const std::vector<const CLI::Option*> words = positionals(*command);
    const std::string action = words.empty() ? "" : action_of(value_of(*words.front()));
    if (!action.empty()) arguments += fmt::format("    {}:*) {} ;;\n", command->get_name(), action);
  }
  for (const CLI::Option* option : named_options(app)) {
    for (const std::string& name : dashed_names(*option)) commands.push_back(name);
  }
  return fmt::format(kScript, fmt::arg("commands", fmt::join(commands, " ")), fmt::arg("values", values),
                     fmt::arg("names", names), fmt::arg("arguments", arguments));
}

}  // namespace cylpose::apps
