#include "cluster_backend.hpp"

#include <fmt/format.h>

#include <cylpose/cluster/backend.hpp>
#include <cylpose/default_backend.hpp>

#include "cluster_options.hpp"

namespace cylpose::apps {

void add_cluster_backend(CLI::App& estimate, ClusterArguments& arguments) {
  add_connection_options(estimate, arguments);
  estimate
      .add_option("--deadline", arguments.deadline_ms,
                  fmt::format("Milliseconds after which the local device does what nodes owe (default: {})",
                              arguments.deadline_ms))
      ->type_name("MS")
      ->group("NATS server");
  register_backend({"cluster", "the local device and workers on other machines (--server)",
                    [] { return cluster_backend(make_default_backend().backend, {}); }});
}

std::unique_ptr<Backend> cluster_backend(std::unique_ptr<Backend> local, const ClusterArguments& arguments) {
  cluster::ClusterOptions options;
  options.connection = connection_options(arguments);
  options.deadline = std::chrono::milliseconds(arguments.deadline_ms);
  options.on_event = tell_user;
  return cluster::make_cluster_backend(std::move(local), options);
}

}  // namespace cylpose::apps
