// The backend cluster among the others.
#include <chrono>
#include <cstdlib>
#include <cylpose/cluster/backend.hpp>
#include <cylpose/error.hpp>
#include <cylpose/opencl_devices.hpp>
#include <string>
#include <thread>

#include "benchmarks.hpp"

namespace cylpose::bench {
namespace {

std::unique_ptr<Backend> with_a_worker(const std::string& server) {
  constexpr std::chrono::seconds kPatience(30);
  cluster::ClusterOptions options;
  options.connection.servers = {server};
  auto backend = cluster::make_cluster_backend(make_opencl_backend(), options);
  const auto end = std::chrono::steady_clock::now() + kPatience;
  while (backend->nodes().empty()) {
    if (std::chrono::steady_clock::now() > end) throw Error(ErrorKind::kDevice, "no worker came to " + server);
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  return backend;
}

}  // namespace

void register_cluster_backend() {
  const char* server = std::getenv("CYLPOSE_BENCH_SERVER");
  if (server == nullptr) return;
  register_backend(
      {"cluster", "the local device and workers", [url = std::string(server)] { return with_a_worker(url); }});
}

}  // namespace cylpose::bench
