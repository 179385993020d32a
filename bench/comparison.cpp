#include "comparison.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>

namespace cylpose::bench {
namespace {

std::map<std::string, std::vector<double>> times_by_name(const std::vector<BenchRun>& runs) {
  std::map<std::string, std::vector<double>> times;
  for (const BenchRun& run : runs) {
    for (const Measured& benchmark : run.benchmarks) {
      std::vector<double>& all = times[benchmark.name];
      all.insert(all.end(), benchmark.milliseconds.begin(), benchmark.milliseconds.end());
    }
  }
  return times;
}

}  // namespace

std::vector<Change> changes(const std::vector<BenchRun>& old_runs, const std::vector<BenchRun>& new_runs) {
  const auto old_times = times_by_name(old_runs);
  std::vector<Change> result;
  for (const auto& [name, times] : times_by_name(new_runs)) {
    const auto before = old_times.find(name);
    if (before == old_times.end()) continue;
    result.push_back(
        {name, median(before->second), std::ranges::max(before->second), median(times), std::ranges::min(times)});
  }
  return result;
}

std::string text_of(const std::vector<Change>& changes) {
  std::string text = fmt::format("{:<34}{:>11}{:>11}{:>11}{:>11}{:>9}\n", "milliseconds", "old median", "new median",
                                 "old worst", "new best", "new/old");
  for (const Change& change : changes) {
    text += fmt::format("{:<34}{:>11.4f}{:>11.4f}{:>11.4f}{:>11.4f}{:>9.2f}{}\n", change.name, change.old_median,
                        change.new_median, change.old_worst, change.new_best, change.new_median / change.old_median,
                        change.is_slower() ? "  SLOWER" : "");
  }
  return text;
}

}  // namespace cylpose::bench
