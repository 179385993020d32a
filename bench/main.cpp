// cylpose_bench: the options of Google Benchmark (--help), and the names of docs/bench.md.
#include <benchmark/benchmark.h>
#include <fmt/format.h>

#include <algorithm>
#include <cylpose/error.hpp>
#include <exception>
#include <regex>
#include <span>
#include <string>
#include <string_view>

#include "benchmarks.hpp"
#include "context.hpp"
#include "reporter.hpp"

namespace {

using namespace cylpose;

// The library would match against names with its suffixes, so that "720$" fits none.
class NameFilter {
 public:
  explicit NameFilter(const std::string& text)
      : negative_(text.starts_with('-')), pattern_(negative_ ? text.substr(1) : text) {}

  [[nodiscard]] bool wants(const std::string& name) const { return std::regex_search(name, pattern_) != negative_; }

 private:
  bool negative_;
  std::regex pattern_;
};

void register_wanted(const NameFilter& filter) {
  const bench::Register add = [&](const std::string& name, std::function<void(benchmark::State&)> run) {
    benchmark::internal::Benchmark* added = nullptr;
    if (filter.wants(name)) {
      added = benchmark::RegisterBenchmark(name.c_str(), std::move(run));
      added->Unit(benchmark::kMillisecond);
    }
    return added;
  };
  bench::register_backend_benchmarks(add);
  bench::register_start_benchmarks(add);
  bench::register_pipeline_benchmarks(add);
#ifdef CYLPOSE_BENCH_LIVE
  bench::register_live_benchmarks(add);
#endif
  bench::register_bandwidth_benchmarks(add);
}

bool succeeds(bool to_file) {
  bench::ConsoleReporter console;
  bench::JsonReporter json;
  const std::size_t count = benchmark::RunSpecifiedBenchmarks(&console, to_file ? &json : nullptr, ".");
  return count > 0 && !console.failed();
}

}  // namespace

int main(int argc, char** argv) {
  constexpr std::string_view kFirstResult = "--first-result=";
  try {
#ifdef CYLPOSE_BENCH_CLUSTER
    bench::register_cluster_backend();
#endif
    if (argc == 2 && std::string_view(argv[1]).starts_with(kFirstResult)) {
      bench::print_first_result_time(std::string(argv[1]).substr(kFirstResult.size()));
      return 0;
    }
    const bool to_file =
        std::ranges::any_of(std::span(argv, static_cast<std::size_t>(argc)),
                            [](std::string_view argument) { return argument.starts_with("--benchmark_out="); });
    benchmark::Initialize(&argc, argv);
    if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
    bench::describe_machine();
    register_wanted(NameFilter(benchmark::GetBenchmarkFilter()));
    return succeeds(to_file) ? 0 : 1;
  } catch (const std::regex_error& error) {
    fmt::print(stderr, "cylpose_bench: --benchmark_filter: {}\n", error.what());
    return 2;
  } catch (const std::exception& error) {
    fmt::print(stderr, "cylpose_bench: {}\n", error.what());
    return 1;
  }
}
