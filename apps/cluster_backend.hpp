// The cluster backend of `cylpose estimate`, with its options; a build without the cluster has neither.
#pragma once

#include <CLI/CLI.hpp>
#include <cylpose/backend.hpp>
#include <memory>
#include <string>
#include <vector>

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

/// Warnings go to standard error. Throws Error.
[[nodiscard]] std::unique_ptr<Backend> cluster_backend(std::unique_ptr<Backend> local,
                                                       const ClusterArguments& arguments);

}  // namespace cylpose::apps
