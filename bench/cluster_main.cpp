// Measures the cluster backend against a server and workers that scripts/bench cluster starts. URL is the server's.
//
//   cylpose_cluster_bench frames URL NODES       time of a frame, nodes alone and together with the local device
//   cylpose_cluster_bench rate URL NODES         frames a second by nodes alone, several frames under way
//   cylpose_cluster_bench soak URL FRAMES        frames compared with serial, whatever happens to nodes and server
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdlib>
#include <cylpose/cluster/backend.hpp>
#include <cylpose/error.hpp>
#include <cylpose/opencl_devices.hpp>
#include <fstream>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "scenes.hpp"

namespace {

using namespace cylpose;
using Clock = std::chrono::steady_clock;
using std::chrono::milliseconds;

double ms_since(Clock::time_point start) {
  return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

double share_of(std::vector<double> values, double share) {
  const auto place = static_cast<std::size_t>(share * static_cast<double>(values.size() - 1));
  std::ranges::nth_element(values, values.begin() + static_cast<std::ptrdiff_t>(place));
  return values[place];
}

double resident_mib() {
  std::ifstream file("/proc/self/statm");
  double total = 0;
  double resident = 0;
  file >> total >> resident;
  return resident * static_cast<double>(::sysconf(_SC_PAGESIZE)) / (1 << 20);
}

std::unique_ptr<cluster::ClusterBackend> coordinator(const std::string& url, bool share_local, milliseconds deadline) {
  cluster::ClusterOptions options;
  options.connection.servers = {url};
  options.share_local = share_local;
  options.deadline = deadline;
  return cluster::make_cluster_backend(make_opencl_backend(), options);
}

void wait_for_nodes(const cluster::ClusterBackend& backend, std::size_t count) {
  constexpr std::chrono::seconds kPatience{30};
  constexpr milliseconds kLook{10};
  const auto start = Clock::now();
  while (backend.nodes().size() < count) {
    if (Clock::now() - start > kPatience) {
      throw Error(ErrorKind::kDevice, fmt::format("only {} of {} nodes came", backend.nodes().size(), count));
    }
    std::this_thread::sleep_for(kLook);
  }
}

bool same(const EdgeField& a, const EdgeField& b) {
  return std::ranges::equal(a.parts, b.parts, [](const PartEdges& x, const PartEdges& y) {
    return x.region == y.region && x.edges == y.edges;
  });
}

struct Case {
  std::string name;
  bench::BenchScene scene;
};

std::vector<Case> cases() {
  Case small{"640x400 whole", bench::full_scene({640, 400})};
  Case large{"1280x720 whole", bench::full_scene({1280, 720})};
  Case region{"375x125 region", large.scene};
  region.scene.search = {(1280 - 375) / 2, (720 - 125) / 2, 375, 125};
  return {small, large, region};
}

EdgeField detect(Backend& backend, const bench::BenchScene& scene) {
  return backend.detect(scene.image(), scene.search, scene.parts, {});
}

double timed(Backend& backend, const Case& one, const EdgeField& expected) {
  const auto start = Clock::now();
  const EdgeField field = detect(backend, one.scene);
  const double ms = ms_since(start);
  if (!same(field, expected)) throw Error(ErrorKind::kDevice, one.name + ": not the serial answer");
  return ms;
}

void frames(const std::string& url, std::size_t nodes) {
  constexpr int kWarmUp = 30;
  constexpr int kFrames = 1000;
  const auto local = make_opencl_backend();
  const auto serial = make_backend("serial");
  fmt::print("{:<16} {:>12} {:>8} {:>14} {:>14} {:>8} {:>8}\n", "ms a frame", "nodes alone", "p99", "nodes + local",
             "opencl alone", "ratio", "shared");
  for (const Case& one : cases()) {
    const EdgeField expected = detect(*serial, one.scene);
    std::vector<double> remote_ms{0};
    if (nodes > 0) {
      const auto remote = coordinator(url, false, milliseconds(1000));
      wait_for_nodes(*remote, nodes);
      for (int i = 0; i < kWarmUp; ++i) static_cast<void>(timed(*remote, one, expected));
      for (int i = 0; i < kFrames / 4; ++i) remote_ms.push_back(timed(*remote, one, expected));
    }
    const auto shared = coordinator(url, true, milliseconds(1000));
    wait_for_nodes(*shared, nodes);
    std::vector<double> shared_ms;
    std::vector<double> local_ms;
    // In turns, and the order in turns: a machine that changes its speed treats both alike.
    for (int i = 0; i < kWarmUp + kFrames; ++i) {
      double ms[2] = {};
      for (const int which : {i % 2, 1 - i % 2}) {
        ms[which] = timed(which == 0 ? static_cast<Backend&>(*shared) : *local, one, expected);
      }
      if (i < kWarmUp) continue;
      shared_ms.push_back(ms[0]);
      local_ms.push_back(ms[1]);
    }
    const double both = share_of(shared_ms, 0.5);
    const double alone = share_of(local_ms, 0.5);
    fmt::print("{:<16} {:>12.2f} {:>8.2f} {:>14.3f} {:>14.3f} {:>8.3f} {:>8}\n", one.name, share_of(remote_ms, 0.5),
               share_of(remote_ms, 0.99), both, alone, both / alone, shared->counters().shared_frames);
  }
}

void rate(const std::string& url, std::size_t nodes) {
  constexpr std::chrono::seconds kWarmUp{2};
  constexpr std::chrono::seconds kDuration{10};
  const auto remote = coordinator(url, false, milliseconds(5000));
  wait_for_nodes(*remote, nodes);
  const bench::BenchScene scene = bench::full_scene({640, 400});
  const EdgeField expected = detect(*make_backend("serial"), scene);
  std::atomic<std::int64_t> done = 0;
  std::atomic<bool> wrong = false;
  {
    std::vector<std::jthread> threads;
    for (std::size_t i = 0; i < nodes + 1; ++i) {
      threads.emplace_back([&](const std::stop_token& stop) {
        while (!stop.stop_requested()) {
          if (!same(detect(*remote, scene), expected)) wrong = true;
          ++done;
        }
      });
    }
    std::this_thread::sleep_for(kWarmUp);
    const std::int64_t before = done;
    const auto start = Clock::now();
    std::this_thread::sleep_for(kDuration);
    fmt::print("{} nodes: {:.1f} frames/s of 640x400", nodes,
               static_cast<double>(done - before) * 1e3 / ms_since(start));
  }
  const cluster::ClusterCounters counters = remote->counters();
  fmt::print(", {} tiles of {} taken back\n", counters.taken_back, counters.sent);
  if (wrong) throw Error(ErrorKind::kDevice, "not the serial answer");
}

void soak(const std::string& url, int count) {
  constexpr milliseconds kDeadline{50};
  const auto remote = coordinator(url, false, kDeadline);
  const auto serial = make_backend("serial");
  std::vector<bench::BenchScene> scenes;
  std::vector<EdgeField> expected;
  for (int i = 0; i < 16; ++i) {
    bench::BenchScene scene = bench::full_scene({640, 400});
    scene.search = {i * 8, i * 4, 375, 250};
    expected.push_back(detect(*serial, scene));
    scenes.push_back(std::move(scene));
  }
  std::vector<double> times;
  int wrong = 0;
  double early_mib = 0;
  for (int i = 0; i < count; ++i) {
    const std::size_t which = static_cast<std::size_t>(i) % scenes.size();
    const auto start = Clock::now();
    const EdgeField field = detect(*remote, scenes[which]);
    times.push_back(ms_since(start));
    wrong += same(field, expected[which]) ? 0 : 1;
    if (i == count / 5) early_mib = resident_mib();
  }
  const cluster::ClusterCounters counters = remote->counters();
  fmt::print("{} frames, 0 lost, {} wrong; median {:.2f} ms, p99 {:.2f} ms, longest {:.2f} ms (deadline {} ms)\n",
             count, wrong, share_of(times, 0.5), share_of(times, 0.99), share_of(times, 1), kDeadline.count());
  fmt::print(
      "tiles: {} sent, {} used, {} late, {} refused, {} taken back; memory {:.1f} MiB after a fifth, {:.1f} MiB "
      "at the end\n",
      counters.sent, counters.used, counters.late, counters.refused, counters.taken_back, early_mib, resident_mib());
  if (wrong > 0) throw Error(ErrorKind::kDevice, "not the serial answer");
}

}  // namespace

int main(int argc, char** argv) {
  try {
    if (argc != 4) throw Error(ErrorKind::kInput, "usage: cylpose_cluster_bench frames|rate|soak URL NUMBER");
    const std::string_view what = argv[1];
    const int number = std::atoi(argv[3]);
    if (what == "frames") frames(argv[2], static_cast<std::size_t>(number));
    if (what == "rate") rate(argv[2], static_cast<std::size_t>(number));
    if (what == "soak") soak(argv[2], number);
    return 0;
  } catch (const std::exception& error) {
    fmt::print(stderr, "cylpose_cluster_bench: {}\n", error.what());
    return 1;
  }
}
