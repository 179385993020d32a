#include <CLI/CLI.hpp>
#include <cstdio>
#include <cylpose/error.hpp>
#include <cylpose/version.hpp>
#include <exception>
#include <memory>

#include "commands.hpp"
#include "help_text.hpp"

namespace {

using namespace cylpose;

int exit_code_of(const Error& error) {
  switch (error.kind()) {
    case ErrorKind::kInput:
      return apps::kInputError;
    case ErrorKind::kOutput:
      return apps::kOutputError;
    case ErrorKind::kDevice:
      return apps::kDeviceError;
  }
  return apps::kInternalError;
}

int run(int argc, char** argv) {
  CLI::App app{"cylpose: where a coloured cylinder of known size is, from the images of one calibrated camera."};
  app.name("cylpose");
  app.require_subcommand(1);
  app.set_version_flag("--version", std::string("cylpose ") + kVersion);
  // Subcommands inherit both.
  app.formatter(std::make_shared<apps::HelpFormatter>());
  app.footer(apps::exit_codes_line());
  apps::add_estimate_command(app);
  apps::add_evaluate_command(app);
  apps::add_synth_command(app);
  apps::add_tune_command(app);
  apps::add_devices_command(app);
  apps::add_cluster_commands(app);
  apps::add_reference_command(app);

  try {
    app.parse(argc, argv);
    return apps::kSuccess;
  } catch (const CLI::RuntimeError& leave) {
    return leave.get_exit_code();
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? apps::kSuccess : apps::kInputError;
  }
}

}  // namespace

int main(int argc, char** argv) {
  // std::fprintf and not fmt::print: what reports a failure must not throw itself.
  try {
    return run(argc, argv);
  } catch (const Error& error) {
    std::fprintf(stderr, "cylpose: %s\n", error.what());
    return exit_code_of(error);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "cylpose: internal error: %s\n", error.what());
    return apps::kInternalError;
  }
}
