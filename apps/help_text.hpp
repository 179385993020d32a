// What `--help` says beside the option tables, and in which form.
#pragma once

#include <CLI/CLI.hpp>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace cylpose::apps {

struct ExitCodeText {
  int code;
  std::string_view meaning;
};

/// Those of every subcommand, see ExitCode.
[[nodiscard]] std::span<const ExitCodeText> exit_code_texts();

/// The end of a help text without examples.
[[nodiscard]] std::string exit_codes_line();

/// Ends the help text of a command with lines to copy, each a whole command line, and the exit codes.
void set_examples(CLI::App& command, const std::vector<std::string>& lines);

/// The lines given to set_examples.
[[nodiscard]] std::vector<std::string> examples_of(const CLI::App& command);

/// What an option means, and whether it must be given or needs another one.
[[nodiscard]] std::string description_of(const CLI::Option& option);

/// CLI11's help with descriptions broken into lines that a terminal of 100 columns holds.
class HelpFormatter : public CLI::Formatter {
 public:
  HelpFormatter();
  [[nodiscard]] std::string make_help(const CLI::App* app, std::string name, CLI::AppFormatMode mode) const override;
  [[nodiscard]] std::string make_option_opts(const CLI::Option* option) const override;
  [[nodiscard]] std::string make_option_desc(const CLI::Option* option) const override;
  [[nodiscard]] std::string make_subcommand(const CLI::App* command) const override;
};

}  // namespace cylpose::apps
