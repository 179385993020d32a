// Reports under the names that were registered, and keeps whether a benchmark failed.
#pragma once

#include <benchmark/benchmark.h>
#include <unistd.h>

#include <algorithm>
#include <string>
#include <string_view>
#include <vector>

#include "stage_counter.hpp"

namespace cylpose::bench {

/// `Base` without the suffixes that the library adds to names for the kind of time, iterations, repetitions and
/// threads.
template <typename Base>
class Reporter : public Base {
 public:
  using Run = benchmark::BenchmarkReporter::Run;

  void ReportRuns(const std::vector<Run>& runs) override {
    std::vector<Run> named = runs;
    for (Run& run : named) {
      run.run_name.time_type.clear();
      run.run_name.iterations.clear();
      run.run_name.repetitions.clear();
      run.run_name.threads.clear();
      failed_ = failed_ || run.error_occurred;
      simplify(run);
    }
    Base::ReportRuns(named);
  }

  [[nodiscard]] bool failed() const { return failed_; }

 protected:
  virtual void simplify(Run& /*run*/) {}

 private:
  bool failed_ = false;
};

/// On the terminal, stages would make lines of several hundred characters; the file and its table have them.
class ConsoleReporter : public Reporter<benchmark::ConsoleReporter> {
 public:
  ConsoleReporter() {
    if (::isatty(STDOUT_FILENO) == 0) output_options_ = OO_Tabular;
  }

 protected:
  void simplify(Run& run) override {
    std::erase_if(run.counters, [](const auto& counter) {
      return std::string_view(counter.first).starts_with(kStageCounter) || counter.first == "frame_bytes";
    });
  }
};

using JsonReporter = Reporter<benchmark::JSONReporter>;

}  // namespace cylpose::bench
