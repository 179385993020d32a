#include <fmt/format.h>
#include <fmt/ranges.h>
#include <malloc.h>

#include <cstdlib>
#include <cylpose/cluster/archive.hpp>
#include <cylpose/cluster/hang_watch.hpp>
#include <cylpose/cluster/worker.hpp>
#include <cylpose/opencl_devices.hpp>
#include <memory>
#include <string>
#include <vector>

#include "cluster_commands.hpp"
#include "cluster_options.hpp"
#include "commands.hpp"
#include "help_text.hpp"
#include "interrupt.hpp"

namespace cylpose::apps {
namespace {

struct Arguments {
  ClusterArguments connection;
  std::string name = "worker";
  std::string backend = "opencl";
  std::string device;
  int hang_ms = 10'000;
  bool jobs = false;
};

std::unique_ptr<Backend> backend_for(const Arguments& arguments, std::string& device) {
  if (arguments.backend != "opencl") {
    device = arguments.backend;
    return make_backend(arguments.backend);
  }
  OpenclOptions options;
  options.device = arguments.device;
  auto backend = make_opencl_backend(options);
  for (const OpenclDevice& used : backend->devices()) device += (device.empty() ? "" : ", ") + used.name;
  return backend;
}

// All but the one that gives work to workers.
std::vector<std::string> local_backends() {
  std::vector<std::string> names;
  for (const BackendInfo& backend : backends()) {
    if (backend.name != "cluster") names.emplace_back(backend.name);
  }
  return names;
}

// A tile comes and goes with some megabytes in large pieces. Returned to the system whenever no tile is waiting, they
// cost the next tile a page fault for every 4 KiB: a quarter of the time of a worker.
void keep_freed_memory() {
  constexpr int kMegabyte = 1 << 20;
  mallopt(M_MMAP_THRESHOLD, 32 * kMegabyte);
  mallopt(M_TRIM_THRESHOLD, 64 * kMegabyte);
}

void work(const Arguments& arguments) {
  keep_freed_memory();
  const InterruptGuard interrupt;
  cluster::WorkerOptions options;
  options.connection = connection_options(arguments.connection);
  options.name = arguments.name;
  options.on_event = tell_user;
  const auto end = [](const std::string& what) {
    tell_user(what + "; ending, to be started again");
    std::_Exit(kDeviceError);
  };
  const std::unique_ptr<Backend> backend =
      cluster::watched(backend_for(arguments, options.device), std::chrono::milliseconds(arguments.hang_ms), end);
  if (arguments.jobs) {
    cluster::run_jobs(*backend, options.connection, InterruptGuard::requested, tell_user);
    return;
  }
  cluster::run_worker(*backend, options, InterruptGuard::requested);
}

}  // namespace

void add_worker_command(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "worker", "Work for `cylpose estimate --backend cluster` on other machines, until it is ended.");
  set_examples(*command, {"cylpose worker --server nats://HOST:4222 --name worker1",
                          "cylpose worker --server nats://HOST:4222 --jobs"});
  const auto arguments = std::make_shared<Arguments>();
  add_connection_options(*command, arguments->connection);
  command->add_option("--name", arguments->name, "Name in lists and in the server's permissions (default: worker)")
      ->type_name("NAME");
  command->add_option("--backend", arguments->backend, "Who does the work (default: opencl)")
      ->type_name(fmt::format("{}", fmt::join(local_backends(), "|")));
  command->add_option("--device", arguments->device, "OpenCL devices, as for `cylpose estimate`")->type_name("DEVICE");
  command
      ->add_option("--hang", arguments->hang_ms,
                   fmt::format("End when a tile or frame takes the device so many milliseconds (default: {})",
                               arguments->hang_ms))
      ->type_name("MS");
  command->add_flag("--jobs", arguments->jobs, "Work on recordings (`cylpose submit`) instead of live frames");
  command->callback([arguments] { work(*arguments); });
}

}  // namespace cylpose::apps
