// The subcommands of a build with the cluster.
#pragma once

#include <CLI/CLI.hpp>

namespace cylpose::apps {

/// submit and collect.
void add_archive_commands(CLI::App& app);
void add_key_command(CLI::App& app);
void add_nodes_command(CLI::App& app);
void add_worker_command(CLI::App& app);

}  // namespace cylpose::apps
