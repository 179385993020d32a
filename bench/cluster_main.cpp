// Measures the cluster backend against a server and workers that scripts/bench cluster starts. URL is the server's.
//
//   cylpose_cluster_bench frames URL NODES       time of a frame, nodes alone and together with the local device
//   cylpose_cluster_bench shared URL NODES       only the latter
//   cylpose_cluster_bench stalled URL PORT       the latter over a link that stands still again and again, on that port
//   cylpose_cluster_bench rate URL NODES         frames a second by nodes alone, several frames under way
//   cylpose_cluster_bench link URL PORT          time of a frame over links of several rates, and with tiles of several
//                                                heights; the link is a proxy of its own on that port
//   cylpose_cluster_bench soak URL FRAMES PID    frames compared with serial, whatever happens to nodes and server; the
//                                                memory of it and of the worker with that process id
//   cylpose_cluster_bench start URL 1            the time, ms since 1970, at which a worker has done its first tile
//
// Of rate and link a fourth argument names a file to which results are added for cylpose_cluster_model.
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
#include <numeric>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "cluster/throttled_link.hpp"
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

double mean_of(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

double resident_mib(std::string_view process = "self") {
  std::ifstream file(fmt::format("/proc/{}/statm", process));
  double total = 0;
  double resident = 0;
  file >> total >> resident;
  return resident * static_cast<double>(::sysconf(_SC_PAGESIZE)) / (1 << 20);
}

int port_of(const std::string& url) {
  return std::stoi(url.substr(url.rfind(':') + 1));
}

/// Lines `what,x,value`.
class Results {
 public:
  explicit Results(const char* path) {
    if (path != nullptr) file_.open(path, std::ios::app);
  }
  void add(std::string_view what, double x, double value) { file_ << fmt::format("{},{:g},{:g}\n", what, x, value); }
  void add(std::string_view what, double value) { file_ << fmt::format("{},,{:g}\n", what, value); }

 private:
  std::ofstream file_;
};

std::unique_ptr<cluster::ClusterBackend> coordinator(const std::string& url, bool share_local, milliseconds deadline,
                                                     int tile_rows = 0) {
  cluster::ClusterOptions options;
  options.tile_rows = tile_rows;
  options.connection.servers = {url};
  options.share_local = share_local;
  options.deadline = deadline;
  return cluster::make_cluster_backend(make_opencl_backend(), options);
}

void wait_for_nodes(const cluster::ClusterBackend& backend, std::size_t count) {
  constexpr std::chrono::seconds kPatience{30};
  constexpr milliseconds kLook{1};
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

enum class Compare { kNodesToo, kSharedOnly };

void frames(const std::string& url, std::size_t nodes, Compare compare) {
  constexpr int kWarmUp = 30;
  const int frames = compare == Compare::kNodesToo ? 1000 : 20'000;  // long enough for things to happen meanwhile
  const auto local = make_opencl_backend();
  const auto serial = make_backend("serial");
  fmt::print("{:<16} {:>12} {:>8} {:>14} {:>14} {:>8} {:>9} {:>8}\n", "ms a frame", "nodes alone", "p99",
             "nodes + local", "opencl alone", "ratio", "of means", "shared");
  for (const Case& one : cases()) {
    const EdgeField expected = detect(*serial, one.scene);
    std::vector<double> remote_ms{0};
    if (nodes > 0 && compare == Compare::kNodesToo) {
      const auto remote = coordinator(url, false, milliseconds(1000));
      wait_for_nodes(*remote, nodes);
      for (int i = 0; i < kWarmUp; ++i) static_cast<void>(timed(*remote, one, expected));
      for (int i = 0; i < frames / 4; ++i) remote_ms.push_back(timed(*remote, one, expected));
    }
    const auto shared = coordinator(url, true, milliseconds(1000));
    wait_for_nodes(*shared, nodes);
    std::vector<double> shared_ms;
    std::vector<double> local_ms;
    // In turns, and the order in turns: a machine that changes its speed treats both alike.
    for (int i = 0; i < kWarmUp + frames; ++i) {
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
    fmt::print("{:<16} {:>12.2f} {:>8.2f} {:>14.3f} {:>14.3f} {:>8.3f} {:>9.3f} {:>8}\n", one.name,
               share_of(remote_ms, 0.5), share_of(remote_ms, 0.99), both, alone, both / alone,
               mean_of(shared_ms) / mean_of(local_ms), shared->counters().shared_frames);
  }
}

// The coordinator's own link stands still and goes on, again and again.
void stalled(const std::string& url, int port) {
  testing::ThrottledLink link(port, port_of(url));
  const std::jthread staller([&](const std::stop_token& stop) {
    constexpr milliseconds kTurn{300};
    while (!stop.stop_requested()) {
      link.settings().stalled = !link.settings().stalled;
      std::this_thread::sleep_for(kTurn);
    }
    link.settings().stalled = false;
  });
  frames("nats://127.0.0.1:" + std::to_string(port), 1, Compare::kSharedOnly);
}

double median_ms(cluster::ClusterBackend& backend, const Case& one, const EdgeField& expected) {
  constexpr std::chrono::seconds kLongest{5};
  constexpr std::size_t kMost = 100;
  constexpr int kWarmUp = 3;
  for (int i = 0; i < kWarmUp; ++i) static_cast<void>(timed(backend, one, expected));
  std::vector<double> ms;
  for (const auto start = Clock::now(); ms.size() < kMost && Clock::now() - start < kLongest;) {
    ms.push_back(timed(backend, one, expected));
  }
  return share_of(ms, 0.5);
}

double bytes_of(const Roi& search, int rows) {
  const int tiles = (search.height + rows - 1) / rows;
  return 3.0 * search.width * (search.height + 2 * kStripHalo * tiles);
}

// The constants of the model first, through the link without a limit.
void links(const std::string& url, int port, Results& results) {
  constexpr int kTallRows = 240;
  constexpr int kThinRows = 32;
  testing::ThrottledLink link(port, port_of(url));
  const std::string there = "nats://127.0.0.1:" + std::to_string(port);
  const auto serial = make_backend("serial");
  const std::vector<Case> all = cases();
  const Case& large = all[1];
  const Case& region = all[2];
  const EdgeField expected = detect(*serial, large.scene);
  const auto measured = [&](const Case& one, const EdgeField& answer, int rows) {
    const auto backend = coordinator(there, false, milliseconds(5000), rows);
    wait_for_nodes(*backend, 1);
    return median_ms(*backend, one, answer);
  };
  const auto backend = coordinator(there, false, milliseconds(5000));
  wait_for_nodes(*backend, 1);
  constexpr int kLocatings = 50;
  std::vector<double> locating;
  locating.reserve(kLocatings);
  for (int i = 0; i < kLocatings; ++i) locating.push_back(detect(*backend, large.scene).times.back().milliseconds);
  std::this_thread::sleep_for(std::chrono::seconds(1));  // until the worker has told its rate
  const double ms_per_mpixel = 1e6 / backend->nodes().at(0).pixels_per_ms;
  const double locate_ms = share_of(locating, 0.5);
  const double small_ms = measured(region, detect(*serial, region.scene), 0);
  const double tall_ms = measured(large, expected, kTallRows);
  const double thin_ms = measured(large, expected, kThinRows);
  const double small_bytes = bytes_of(region.scene.search, region.scene.search.height);
  const double tall_bytes = bytes_of(large.scene.search, kTallRows);
  const double work_ms = ms_per_mpixel * 1280 * (kTallRows - 375.0 * 125 / 1280) * 1e-6;  // of the last tile
  const double mb_per_s = (tall_bytes - small_bytes) * 1e-3 / (tall_ms - small_ms - work_ms);
  const double thin_bytes = bytes_of(large.scene.search, kThinRows);
  const double more_tiles = 720.0 / kThinRows - 720.0 / kTallRows;
  const double tile_ms = std::max(0.0, thin_ms - tall_ms - (thin_bytes - tall_bytes) * 1e-3 / mb_per_s) / more_tiles;
  const double hop_ms =
      std::max(0.0, small_ms - small_bytes * 1e-3 / mb_per_s - ms_per_mpixel * 375 * 125 * 1e-6 - locate_ms - tile_ms) /
      2;
  fmt::print("loopback {:.0f} MB/s, {:.3f} ms a hop, {:.3f} ms a tile, {:.2f} ms/Mpixel, locating {:.2f} ms\n",
             mb_per_s, hop_ms, tile_ms, ms_per_mpixel, locate_ms);
  results.add("loopback_mb_per_s", mb_per_s);
  results.add("hop_ms", hop_ms);
  results.add("tile_ms", tile_ms);
  results.add("ms_per_mpixel", ms_per_mpixel);
  results.add("locate_ms", locate_ms);
  for (const double rate : {12.5, 25.0, 50.0, 100.0, 200.0}) {
    link.settings().bytes_per_ms = rate * 1e3;
    const double ms = measured(large, expected, kTallRows);
    fmt::print("{:>6} MB/s: {:.1f} ms\n", rate, ms);
    results.add("link", rate, ms);
  }
  link.settings().bytes_per_ms = 50e3;
  for (const int rows : {16, 32, 64, 128, 240}) {
    const double ms = measured(large, expected, rows);
    fmt::print("{:>6} rows a tile at 50 MB/s: {:.1f} ms\n", rows, ms);
    results.add("rows", rows, ms);
  }
}

void rate(const std::string& url, std::size_t nodes, Results& results) {
  constexpr std::chrono::seconds kWarmUp{2};
  constexpr std::chrono::seconds kDuration{10};
  constexpr std::size_t kUnderWay = 2;  // frames for each node: one that it works on, one on its way
  const auto remote = coordinator(url, false, milliseconds(5000));
  wait_for_nodes(*remote, nodes);
  // Many parts: with one, the coordinator could not send as fast as eight nodes work.
  bench::BenchScene scene = bench::full_scene({640, 400});
  scene.parts.clear();
  for (double hue = 0; hue < 360; hue += 45)
    scene.parts.push_back({fmt::format("hue{}", hue), 0.05, 0.4, hue, hue + 40, 0.3, 0.2});
  const EdgeField expected = detect(*make_backend("serial"), scene);
  std::atomic<std::int64_t> done = 0;
  std::atomic<bool> wrong = false;
  {
    std::vector<std::jthread> threads;
    for (std::size_t i = 0; i < kUnderWay * nodes; ++i) {
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
    const double per_s = static_cast<double>(done - before) * 1e3 / ms_since(start);
    fmt::print("{} nodes: {:.1f} frames/s of 640x400 with eight parts", nodes, per_s);
    results.add("rate", static_cast<double>(nodes), per_s);
    if (nodes == 1) results.add("held_ms_per_mpixel", 1e9 / per_s / 640 / (400 + 2 * kStripHalo));
  }
  const cluster::ClusterCounters counters = remote->counters();
  fmt::print(", {} tiles sent, {} late, {} taken back\n", counters.sent, counters.late, counters.taken_back);
  if (wrong) throw Error(ErrorKind::kDevice, "not the serial answer");
}

// Frames at the pace of a quick camera, so that what happens meanwhile is spread over all of them.
void soak(const std::string& url, int count, std::string_view worker) {
  constexpr milliseconds kDeadline{50};
  constexpr std::chrono::microseconds kPeriod{1'000'000 / 300};
  const auto remote = coordinator(url, false, kDeadline);
  wait_for_nodes(*remote, 1);
  const auto serial = make_backend("serial");
  const auto local = make_opencl_backend();
  std::vector<bench::BenchScene> scenes;
  std::vector<EdgeField> expected;
  std::vector<double> local_ms;
  for (int i = 0; i < 16; ++i) {
    bench::BenchScene scene = bench::full_scene({640, 400});
    scene.search = {i * 8, i * 4, 375, 250};
    expected.push_back(detect(*serial, scene));
    for (int again = 0; again < 20; ++again) {
      const auto start = Clock::now();
      static_cast<void>(detect(*local, scene));
      local_ms.push_back(ms_since(start));
    }
    scenes.push_back(std::move(scene));
  }
  std::vector<double> times;
  int lost = 0;
  int wrong = 0;
  double early_mib = 0;
  double early_worker_mib = 0;
  const auto begin = Clock::now();
  for (int i = 0; i < count; ++i) {
    std::this_thread::sleep_until(begin + i * kPeriod);
    const std::size_t which = static_cast<std::size_t>(i) % scenes.size();
    const auto start = Clock::now();
    try {
      const EdgeField field = detect(*remote, scenes[which]);
      times.push_back(ms_since(start));
      wrong += same(field, expected[which]) ? 0 : 1;
    } catch (const Error&) {
      ++lost;
    }
    if (i == count / 5) {
      early_mib = resident_mib();
      early_worker_mib = resident_mib(worker);
    }
  }
  const cluster::ClusterCounters counters = remote->counters();
  fmt::print(
      "{} frames in {:.0f} s, {} lost, {} wrong; median {:.2f} ms, p99 {:.2f} ms, longest {:.2f} ms; deadline {} "
      "ms, local p99 {:.2f} ms\n",
      count, ms_since(begin) * 1e-3, lost, wrong, share_of(times, 0.5), share_of(times, 0.99), share_of(times, 1),
      kDeadline.count(), share_of(local_ms, 0.99));
  fmt::print("tiles: {} sent, {} used, {} late, {} refused, {} taken back\n", counters.sent, counters.used,
             counters.late, counters.refused, counters.taken_back);
  fmt::print("memory after a fifth and at the end: coordinator {:.1f}, {:.1f} MiB, worker {:.1f}, {:.1f} MiB\n",
             early_mib, resident_mib(), early_worker_mib, resident_mib(worker));
  if (wrong > 0 || lost > 0) throw Error(ErrorKind::kDevice, "not the serial answer");
}

// When a worker that is started meanwhile has done its first tile.
void first_tile(const std::string& url) {
  const auto remote = coordinator(url, false, milliseconds(100));
  const Case region = cases()[2];
  fmt::print("ready\n");
  std::fflush(stdout);
  while (remote->counters().used == 0) {
    wait_for_nodes(*remote, 1);
    static_cast<void>(detect(*remote, region.scene));
  }
  const auto now = std::chrono::system_clock::now().time_since_epoch();
  fmt::print("{}\n", std::chrono::duration_cast<milliseconds>(now).count());
}

}  // namespace

int main(int argc, char** argv) {
  try {
    const std::string_view what = argc > 1 ? argv[1] : "";
    if (argc != (what == "soak" ? 5 : 4) && !(argc == 5 && (what == "rate" || what == "link"))) {
      throw Error(ErrorKind::kInput,
                  "usage: cylpose_cluster_bench frames|shared|stalled|start URL NUMBER, rate|link URL NUMBER [RESULTS] "
                  "or soak URL FRAMES PID");
    }
    const int number = std::atoi(argv[3]);
    Results results(argc == 5 && what != "soak" ? argv[4] : nullptr);
    const auto nodes = static_cast<std::size_t>(number);
    if (what == "frames") frames(argv[2], nodes, Compare::kNodesToo);
    if (what == "shared") frames(argv[2], nodes, Compare::kSharedOnly);
    if (what == "stalled") stalled(argv[2], number);
    if (what == "rate") rate(argv[2], nodes, results);
    if (what == "link") links(argv[2], number, results);
    if (what == "start") first_tile(argv[2]);
    if (what == "soak") soak(argv[2], number, argv[4]);
    return 0;
  } catch (const std::exception& error) {
    fmt::print(stderr, "cylpose_cluster_bench: {}\n", error.what());
    return 1;
  }
}
