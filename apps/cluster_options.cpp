#include "cluster_options.hpp"

#include <fmt/format.h>

#include <cstdio>

#include "cluster_commands.hpp"
#include "commands.hpp"

namespace cylpose::apps {

void add_connection_options(CLI::App& command, ClusterArguments& arguments) {
  constexpr const char* kGroup = "NATS server";
  command
      .add_option("--server", arguments.servers, "NATS servers, several with commas (default: nats://127.0.0.1:4222)")
      ->delimiter(',')
      ->allow_extra_args(false)  // what follows is an input
      ->type_name("nats://HOST:PORT")
      ->group(kGroup);
  command.add_option("--creds", arguments.creds, "Who we are: NATS credentials, or the seed of an NKey")
      ->type_name("FILE")
      ->group(kGroup);
  command.add_option("--tls-ca", arguments.tls_ca, "Use TLS; the authority that signed the server's certificate")
      ->type_name("FILE")
      ->group(kGroup);
  command.add_option("--tls-cert", arguments.tls_cert, "Our certificate, for servers that ask for one")
      ->type_name("FILE")
      ->group(kGroup);
  command.add_option("--tls-key", arguments.tls_key, "The key of our certificate")->type_name("FILE")->group(kGroup);
}

cluster::ConnectionOptions connection_options(const ClusterArguments& arguments) {
  cluster::ConnectionOptions options;
  options.servers = arguments.servers;
  if (options.servers.empty()) options.servers = {"nats://127.0.0.1:4222"};
  options.creds = arguments.creds;
  options.tls_ca = arguments.tls_ca;
  options.tls_cert = arguments.tls_cert;
  options.tls_key = arguments.tls_key;
  return options;
}

void tell_user(const std::string& what) {
  std::fprintf(stderr, "cylpose: %s\n", what.c_str());
}

void add_cluster_commands(CLI::App& app) {
  add_worker_command(app);
  add_nodes_command(app);
  add_archive_commands(app);
  add_key_command(app);
}

}  // namespace cylpose::apps
