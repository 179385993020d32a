// A node: asks for tiles and does them.
#pragma once

#include <cylpose/backend.hpp>
#include <cylpose/cluster/connection.hpp>
#include <functional>
#include <string>

namespace cylpose::cluster {

struct WorkerOptions {
  ConnectionOptions connection;
  /// Its name, letters, digits, - and _, one word: with permissions by name the one its user may answer under.
  std::string name = "worker";
  /// What it runs on, for `cylpose nodes`.
  std::string device;
  /// Tiles that it takes while it works on others: with 2 the network carries the next one meanwhile. 1 to 64.
  int slots = 2;
  /// Told what the user should know. From any thread.
  std::function<void(const std::string& what)> on_event;

  [[nodiscard]] bool is_valid(std::string* why) const;
};

/// Works until `stop` says so, then answers what it has been given and leaves. Servers that are not there are waited
/// for, ever more slowly, without end. Throws Error(kInput) for options, Error(kDevice) when a server refuses us.
void run_worker(Backend& backend, const WorkerOptions& options, const std::function<bool()>& stop);

}  // namespace cylpose::cluster
