// How coordinators, workers and tools reach the NATS servers.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace cylpose::cluster {

struct ConnectionOptions {
  /// nats://HOST:PORT or tls://HOST:PORT, at least one. With several, which are to form a cluster of NATS's own, the
  /// first that answers is used, and another takes over where one fails.
  std::vector<std::string> servers;
  /// Who we are: a NATS credentials file, or a file with the seed of an NKey (`SU...`). Empty: nobody in particular.
  std::filesystem::path creds;
  /// The authority that signed the server's certificate, PEM. Given, nothing but TLS will do.
  std::filesystem::path tls_ca;
  /// Our own certificate and its key, PEM, for servers that verify clients. Both or none; needs tls_ca.
  std::filesystem::path tls_cert;
  std::filesystem::path tls_key;

  [[nodiscard]] bool is_valid(std::string* why) const;
};

/// A new NKey: the seed is the secret (a file of it goes to ConnectionOptions::creds), the public key stands in the
/// server's configuration. Throws Error(kDevice) where the system gives no random numbers.
struct NKey {
  std::string seed;
  std::string public_key;
};
[[nodiscard]] NKey make_nkey();

}  // namespace cylpose::cluster
