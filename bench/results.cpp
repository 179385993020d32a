#include "results.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cylpose/error.hpp>
#include <fstream>
#include <nlohmann/json.hpp>

#include "stage_counter.hpp"

namespace cylpose::bench {
namespace {

using Json = nlohmann::json;

[[noreturn]] void refuse(const std::filesystem::path& file, const std::string& why) {
  throw Error(ErrorKind::kInput, fmt::format("{}: {}", file.string(), why));
}

double milliseconds_in(const std::string& unit) {
  constexpr std::array<std::pair<std::string_view, double>, 4> kUnits{
      {{"ns", 1e-6}, {"us", 1e-3}, {"ms", 1}, {"s", 1e3}}};
  const auto* known = std::ranges::find(kUnits, unit, &std::pair<std::string_view, double>::first);
  if (known == kUnits.end()) throw Error(ErrorKind::kInput, "unknown unit of time '" + unit + "'");
  return known->second;
}

Measured& entry_of(BenchRun& run, const std::string& name) {
  const auto known = std::ranges::find(run.benchmarks, name, &Measured::name);
  if (known != run.benchmarks.end()) return *known;
  return run.benchmarks.emplace_back(Measured{name, {}, {}});
}

void add(const Json& repetition, BenchRun& run) {
  const auto name = repetition.at("name").get<std::string>();
  if (repetition.value("error_occurred", false)) {
    throw Error(ErrorKind::kInput, fmt::format("{} failed: {}", name, repetition.value("error_message", "")));
  }
  if (repetition.value("run_type", "") != "iteration") return;  // medians and the like are computed here
  Measured& measured = entry_of(run, name);
  measured.milliseconds.push_back(repetition.at("real_time").get<double>() *
                                  milliseconds_in(repetition.at("time_unit").get<std::string>()));
  for (const auto& [key, value] : repetition.items()) {
    if (value.is_number()) measured.counters[key].push_back(value.get<double>());
  }
}

}  // namespace

const Measured* BenchRun::find(std::string_view name) const {
  const auto known = std::ranges::find(benchmarks, name, &Measured::name);
  return known == benchmarks.end() ? nullptr : &*known;
}

BenchRun load_run(const std::filesystem::path& file) {
  std::ifstream stream(file);
  if (!stream) refuse(file, "cannot be read");
  BenchRun run;
  try {
    const Json json = Json::parse(stream);
    for (const auto& [key, value] : json.at("context").items()) {
      if (value.is_string()) run.context[key] = value.get<std::string>();
      if (key == "load_avg") run.context[key] = value.dump();
    }
    for (const Json& repetition : json.at("benchmarks")) add(repetition, run);
  } catch (const Json::exception& error) {
    refuse(file, fmt::format("is no output of cylpose_bench: {}", error.what()));
  } catch (const Error& error) {
    refuse(file, error.what());
  }
  if (run.benchmarks.empty()) refuse(file, "holds no benchmark");
  std::ranges::stable_sort(run.benchmarks, {}, [](const Measured& measured) {
    return median_counter(measured, "family_index").value_or(0);  // the library counts benchmarks as they were added
  });
  return run;
}

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::ranges::nth_element(values, middle);
  if (values.size() % 2 == 1) return *middle;
  return (*std::max_element(values.begin(), middle) + *middle) / 2;
}

std::optional<double> median_counter(const Measured& benchmark, const std::string& counter) {
  const auto known = benchmark.counters.find(counter);
  if (known == benchmark.counters.end()) return std::nullopt;
  return median(known->second);
}

std::vector<Stage> stages_of(const Measured& benchmark) {
  std::vector<Stage> stages;
  for (const auto& [counter, values] : benchmark.counters) {
    if (counter.starts_with(kStageCounter)) stages.push_back({stage_of_counter(counter), median(values)});
  }
  return stages;
}

std::optional<CaseName> parsed_case(std::string_view name) {
  std::array<std::string, 4> pieces;
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    const std::size_t slash = name.find('/');
    const bool last = i + 1 == pieces.size();
    if ((slash == std::string_view::npos) != last) return std::nullopt;
    pieces[i] = name.substr(0, slash);
    name.remove_prefix(last ? name.size() : slash + 1);
  }
  return CaseName{pieces[0], pieces[1], pieces[2], pieces[3]};
}

}  // namespace cylpose::bench
