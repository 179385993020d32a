// How fast this machine reads: the limit for anything that has to look at every pixel.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <numeric>
#include <thread>
#include <vector>

#include "benchmarks.hpp"
#include "scenes.hpp"

namespace cylpose::bench {
namespace {

using Words = std::vector<std::uint64_t>;

// More than any cache holds.
constexpr std::size_t kMemoryBytes = std::size_t{256} << 20;

std::uint64_t sum_of(const std::uint64_t* first, const std::uint64_t* last) {
  return std::accumulate(first, last, std::uint64_t{0});
}

// Every thread reads its share again and again, as the cores of a backend would with the rows of a frame.
void read(std::size_t bytes, benchmark::State& state) {
  const auto threads = static_cast<std::size_t>(state.threads());
  const Words words(bytes / sizeof(std::uint64_t) / threads, 1);
  for (auto _ : state) benchmark::DoNotOptimize(sum_of(words.data(), words.data() + words.size()));
  state.counters["GB/s"] = benchmark::Counter(static_cast<double>(words.size() * sizeof(std::uint64_t)) * 1e-9,
                                              benchmark::Counter::kIsIterationInvariantRate);
}

void register_size(const std::string& what, std::size_t bytes, const Register& add) {
  benchmark::internal::Benchmark* added =
      add("read_bandwidth/" + what, [=](benchmark::State& state) { read(bytes, state); });
  if (added != nullptr)
    added->Threads(static_cast<int>(std::max(1U, std::thread::hardware_concurrency())))->UseRealTime();
}

}  // namespace

void register_bandwidth_benchmarks(const Register& add) {
  for (const FrameSize& size : kFrameSizes) {
    register_size(to_string(size), std::size_t{3} * static_cast<std::size_t>(size.width * size.height), add);
  }
  register_size("memory", kMemoryBytes, add);
}

}  // namespace cylpose::bench
