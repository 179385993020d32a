// What an option takes, read from its type name: `csv|jsonl|tum` is a choice of words, FILE, DIR, out.json and ... are
// paths, anything else (NAME, METRES) is the user's own.
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

namespace cylpose::apps {

struct OptionValue {
  enum class Kind { kNone, kWords, kFile, kFolder, kFree };
  Kind kind = Kind::kNone;
  std::vector<std::string> words;  ///< of kWords
};

[[nodiscard]] OptionValue value_of(const CLI::Option& option);

/// The options of a command that its help shows: those with a dash, or the positional ones.
[[nodiscard]] std::vector<const CLI::Option*> named_options(const CLI::App& command);
[[nodiscard]] std::vector<const CLI::Option*> positionals(const CLI::App& command);

/// The subcommands that the help shows.
[[nodiscard]] std::vector<const CLI::App*> visible_commands(const CLI::App& app);

/// -o, --output
[[nodiscard]] std::vector<std::string> dashed_names(const CLI::Option& option);

}  // namespace cylpose::apps
