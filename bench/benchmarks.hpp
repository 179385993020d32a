// What is timed. Each function registers benchmarks with the names of docs/bench.md.
#pragma once

#include <benchmark/benchmark.h>

#include <functional>
#include <string>

namespace cylpose::bench {

/// Adds a benchmark under its name if it is wanted; null if not. Real or manual time is up to the caller: backends work
/// on threads of their own, so that the calling thread's processor time says nothing.
using Register =
    std::function<benchmark::internal::Benchmark*(const std::string& name, std::function<void(benchmark::State&)>)>;

void register_backend_benchmarks(const Register& add);    ///< detect/..., estimate/..., overhead/...
void register_start_benchmarks(const Register& add);      ///< start/...
void register_pipeline_benchmarks(const Register& add);   ///< pipeline/...
void register_live_benchmarks(const Register& add);       ///< pipeline/live/...; in builds with the command
void register_bandwidth_benchmarks(const Register& add);  ///< read_bandwidth/...

/// Makes `cluster` a backend where $CYLPOSE_BENCH_SERVER names a NATS server; in builds with the cluster. It shares
/// frames with the workers of that server whenever that is quicker, as `cylpose estimate --backend cluster` does.
void register_cluster_backend();

/// The work of the processes that the start benchmarks make: prints the milliseconds from nothing to the first result
/// of the backend. Throws cylpose::Error.
void print_first_result_time(const std::string& backend);

}  // namespace cylpose::bench
