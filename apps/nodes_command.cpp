#include <fmt/format.h>

#include <cylpose/cluster/nodes.hpp>
#include <memory>
#include <string>

#include "cluster_commands.hpp"
#include "cluster_options.hpp"
#include "help_text.hpp"
#include "output.hpp"

namespace cylpose::apps {
namespace {

std::string list_of_nodes(const ClusterArguments& arguments) {
  std::string text;
  for (const cluster::NodeReport& node : cluster::list_nodes(connection_options(arguments))) {
    text += fmt::format("{}.{}  {}\n", node.name, node.id, node.device);
    text += fmt::format("  {} tiles, {} failed, {:.1f} Mpixel/s, since {}\n", node.done, node.failed,
                        node.pixels_per_ms * 1e-3, node.started);
    if (!node.usable) {
      text +=
          fmt::format("  of another version ({}, protocol {}): gets no tiles from here\n", node.version, node.protocol);
    }
    if (!node.last_error.empty()) text += fmt::format("  last failure: {}\n", node.last_error);
  }
  return text.empty() ? "no nodes; start `cylpose worker --server ...` on some machine\n" : text;
}

}  // namespace

void add_nodes_command(CLI::App& app) {
  CLI::App* command = app.add_subcommand("nodes", "List the workers that a NATS server knows.");
  set_examples(*command, {"cylpose nodes --server nats://HOST:4222"});
  const auto arguments = std::make_shared<ClusterArguments>();
  add_connection_options(*command, *arguments);
  command->callback([arguments] { write_stdout(list_of_nodes(*arguments)); });
}

}  // namespace cylpose::apps
