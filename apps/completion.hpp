// Completion of command lines, made from the option tables of the command itself.
#pragma once

#include <CLI/CLI.hpp>
#include <string>

namespace cylpose::apps {

/// A script for bash, to be installed as share/bash-completion/completions/cylpose or read by `source`.
[[nodiscard]] std::string bash_completion(const CLI::App& app);

}  // namespace cylpose::apps
