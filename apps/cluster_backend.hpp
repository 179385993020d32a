// The cluster backend of `cylpose estimate`, with its options; a build without the cluster has neither.
#pragma once

#include <CLI/CLI.hpp>
#include <cylpose/backend.hpp>
#include <memory>
#include <string>
#include <vector>

#include "live/live_state.hpp"

namespace cylpose::apps {

struct ClusterArguments {
  std::vector<std::string> servers;
  std::string creds;
  std::string tls_ca;
  std::string tls_cert;
  std::string tls_key;
  int deadline_ms = 50;
};

/// Adds --server, --creds and the --tls options.
void add_connection_options(CLI::App& command, ClusterArguments& arguments);

/// Adds those and --deadline to `estimate`, and `cluster` to the known backends.
void add_cluster_backend(CLI::App& estimate, ClusterArguments& arguments);

/// Told what the user should know, from any thread.
using Tell = std::function<void(const std::string& what)>;

struct ChosenBackend {
  std::unique_ptr<Backend> backend;
  AskCluster cluster;  ///< while `backend` lives; empty where there is no cluster
};

/// Throws Error.
[[nodiscard]] ChosenBackend cluster_backend(std::unique_ptr<Backend> local, const ClusterArguments& arguments,
                                            const Tell& tell);

}  // namespace cylpose::apps
