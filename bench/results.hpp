// What cylpose_bench wrote, read again.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace cylpose::bench {

/// All repetitions of one benchmark.
struct Measured {
  std::string name;
  std::vector<double> milliseconds;
  std::map<std::string, std::vector<double>> counters;
};

struct BenchRun {
  std::map<std::string, std::string> context;  ///< on what was measured: text, and the load at the start
  std::vector<Measured> benchmarks;            ///< in the order of their registration

  [[nodiscard]] const Measured* find(std::string_view name) const;  ///< null where there is none
};

/// Throws Error(kInput) that names the file unless it holds a run of at least one benchmark, none of which failed.
[[nodiscard]] BenchRun load_run(const std::filesystem::path& file);

/// The middle value, or the mean of the middle two. Requires at least one.
[[nodiscard]] double median(std::vector<double> values);

/// Median of a counter; none where the benchmark does not have it.
[[nodiscard]] std::optional<double> median_counter(const Measured& benchmark, const std::string& counter);

struct Stage {
  std::string name;
  double milliseconds;  ///< median
};

/// The stages of a benchmark that counts them (stage_counter), in the order of the work.
[[nodiscard]] std::vector<Stage> stages_of(const Measured& benchmark);

/// A name of the form <kind>/<backend>/<scene>/<size>.
struct CaseName {
  std::string kind;
  std::string backend;
  std::string scene;
  std::string size;
};

/// None for names of another form.
[[nodiscard]] std::optional<CaseName> parsed_case(std::string_view name);

}  // namespace cylpose::bench
