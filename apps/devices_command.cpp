#include <fmt/format.h>

#include <cylpose/backend.hpp>

#include "commands.hpp"
#include "output.hpp"

namespace cylpose::apps {

void add_devices_command(CLI::App& app) {
  CLI::App* command = app.add_subcommand("devices", "List what can do the per-pixel work (estimate --backend NAME).");
  command->callback([] {
    std::string text = "backends\n";
    for (const BackendInfo& backend : backends()) {
      text += fmt::format("  {:<10} {}\n", backend.name, backend.description);
    }
    write_stdout(text);
  });
}

}  // namespace cylpose::apps
