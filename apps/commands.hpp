// The subcommands of `cylpose`. Each function adds one to the application; its callback does the work and throws
// cylpose::Error for what the user can mend, CLI::RuntimeError to leave with a code of its own.
#pragma once

#include <CLI/CLI.hpp>

namespace cylpose::apps {

/// Exit codes of every subcommand; every `--help` lists them (exit_code_texts).
enum ExitCode {
  kSuccess = 0,
  kInternalError = 1,
  kInputError = 2,  ///< usage, or an input that cannot be used
  kOutputError = 3,
  kDeviceError = 4,
  kInterrupted = 130,
};

/// worker, nodes, submit, collect and key; nothing in a build without the cluster.
void add_cluster_commands(CLI::App& app);
void add_devices_command(CLI::App& app);
void add_estimate_command(CLI::App& app);
void add_evaluate_command(CLI::App& app);
/// What the build asks for manual pages and shell completion; not shown in any help. `app` must outlive its parsing.
void add_reference_command(CLI::App& app);
void add_synth_command(CLI::App& app);
void add_tune_command(CLI::App& app);

}  // namespace cylpose::apps
