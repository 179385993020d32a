#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <cylpose/cluster/connection.hpp>
#include <cylpose/error.hpp>
#include <memory>
#include <string>

#include "cluster_commands.hpp"
#include "help_text.hpp"
#include "output.hpp"

namespace cylpose::apps {
namespace {

// Never over an old one, and for nobody else's eyes.
void keep_secret(const std::string& path, const std::string& seed) {
  const std::string line = seed + "\n";
  const int file = ::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0600);
  const bool written = file >= 0 && ::write(file, line.data(), line.size()) == static_cast<ssize_t>(line.size());
  const int why = errno;
  if (file >= 0) ::close(file);
  if (!written) {
    throw Error(ErrorKind::kOutput,
                fmt::format("{}: cannot be made: {}; name a file that is not there yet", path, std::strerror(why)));
  }
}

}  // namespace

void add_key_command(CLI::App& app) {
  CLI::App* command = app.add_subcommand("key", "Make an NKey for a NATS server; prints the public key.");
  set_examples(*command, {"cylpose key worker1.nk"});
  const auto path = std::make_shared<std::string>();
  command->add_option("FILE", *path, "New file for the secret, to be given as --creds")->required()->type_name("FILE");
  command->callback([path] {
    const cluster::NKey key = cluster::make_nkey();
    keep_secret(*path, key.seed);
    write_stdout(key.public_key + "\n");
  });
}

}  // namespace cylpose::apps
