// In place of the cluster's commands and options in a build without it.
#include <cylpose/error.hpp>

#include "cluster_backend.hpp"
#include "commands.hpp"

namespace cylpose::apps {

void add_cluster_commands(CLI::App& /*app*/) {}

void add_cluster_backend(CLI::App& /*estimate*/, ClusterArguments& /*arguments*/) {}

ChosenBackend cluster_backend(std::unique_ptr<Backend> /*local*/, const ClusterArguments& /*arguments*/,
                              const Tell& /*tell*/) {
  throw Error(ErrorKind::kInput, "this build of cylpose has no cluster; build it with -DCYLPOSE_WITH_CLUSTER=ON");
}

}  // namespace cylpose::apps
