// Manual pages, made from the option tables of the command itself.
#pragma once

#include <CLI/CLI.hpp>
#include <string>

namespace cylpose::apps {

/// cylpose(1), in the man macros of roff.
[[nodiscard]] std::string manual_page(const CLI::App& app);

/// cylpose-COMMAND(1).
[[nodiscard]] std::string manual_page(const CLI::App& app, const CLI::App& command);

}  // namespace cylpose::apps
