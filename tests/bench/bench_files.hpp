// Files as cylpose_bench writes them.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "host/temp_dir.hpp"
#include "results.hpp"

namespace cylpose::bench::testing {

struct Entry {
  std::string name;
  std::vector<double> microseconds;  ///< one per repetition
  nlohmann::json counters = nlohmann::json::object();
};

inline nlohmann::json run_json(const std::vector<Entry>& entries) {
  nlohmann::json json{{"context", {{"date", "today"}, {"processor", "abacus"}, {"load_avg", {0.5, 0.25}}}},
                      {"benchmarks", nlohmann::json::array()}};
  for (std::size_t i = 0; i < entries.size(); ++i) {
    for (const double time : entries[i].microseconds) {
      nlohmann::json repetition{{"name", entries[i].name},
                                {"run_type", "iteration"},
                                {"family_index", i},
                                {"real_time", time},
                                {"time_unit", "us"}};
      repetition.update(entries[i].counters);
      json["benchmarks"].push_back(repetition);
    }
  }
  return json;
}

inline BenchRun loaded_json(const nlohmann::json& json) {
  const TempDir folder;
  return load_run(folder.write("run.json", json.dump()));
}

inline BenchRun loaded(const std::vector<Entry>& entries) {
  return loaded_json(run_json(entries));
}

}  // namespace cylpose::bench::testing
