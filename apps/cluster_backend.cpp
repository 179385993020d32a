#include "cluster_backend.hpp"

#include <fmt/format.h>

#include <cylpose/cluster/backend.hpp>
#include <cylpose/default_backend.hpp>

#include "cluster_options.hpp"

namespace cylpose::apps {
namespace {

ClusterView view_of(const cluster::ClusterBackend& backend) {
  ClusterView view;
  for (const cluster::ClusterNode& node : backend.nodes()) {
    view.nodes.push_back({node.node, node.slots, node.pixels_per_ms, node.done, node.failed});
  }
  const cluster::ClusterCounters counters = backend.counters();
  view.sent = counters.sent;
  view.used = counters.used;
  view.late = counters.late;
  view.refused = counters.refused;
  view.taken_back = counters.taken_back;
  return view;
}

}  // namespace

void add_cluster_backend(CLI::App& estimate, ClusterArguments& arguments) {
  add_connection_options(estimate, arguments);
  estimate
      .add_option("--deadline", arguments.deadline_ms,
                  fmt::format("Milliseconds after which the local device does what nodes owe (default: {})",
                              arguments.deadline_ms))
      ->type_name("MS")
      ->group("NATS server");
  register_backend({"cluster", "the local device and workers on other machines (--server)",
                    [] { return cluster_backend(make_default_backend().backend, {}, tell_user).backend; }});
}

ChosenBackend cluster_backend(std::unique_ptr<Backend> local, const ClusterArguments& arguments, const Tell& tell) {
  cluster::ClusterOptions options;
  options.connection = connection_options(arguments);
  options.deadline = std::chrono::milliseconds(arguments.deadline_ms);
  options.on_event = tell;
  auto backend = cluster::make_cluster_backend(std::move(local), options);
  AskCluster ask = [backend = backend.get()] { return view_of(*backend); };
  return {std::move(backend), std::move(ask)};
}

}  // namespace cylpose::apps
