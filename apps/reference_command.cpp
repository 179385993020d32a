// cylpose reference: what the build installs beside the command. Hidden, for it is the build's and not the user's.
#include <filesystem>
#include <memory>
#include <string>

#include "commands.hpp"
#include "completion.hpp"
#include "manual_page.hpp"
#include "option_value.hpp"
#include "output.hpp"

namespace cylpose::apps {
namespace {

void write_reference(const CLI::App& app, const std::filesystem::path& share) {
  const std::filesystem::path manual = share / "man" / "man1";
  const std::filesystem::path completions = share / "bash-completion" / "completions";
  std::filesystem::create_directories(manual);
  std::filesystem::create_directories(completions);
  write_result(manual / "cylpose.1", manual_page(app));
  for (const CLI::App* command : visible_commands(app)) {
    write_result(manual / ("cylpose-" + command->get_name() + ".1"), manual_page(app, *command));
  }
  write_result(completions / "cylpose", bash_completion(app));
}

}  // namespace

void add_reference_command(CLI::App& app) {
  CLI::App* command = app.add_subcommand("reference", "Write manual pages and shell completion.");
  command->group("");
  const auto folder = std::make_shared<std::string>();
  command->add_option("DIR", *folder, "Folder with the layout of /usr/share")->required()->type_name("");
  command->callback([&app, folder] { write_reference(app, *folder); });
}

}  // namespace cylpose::apps
