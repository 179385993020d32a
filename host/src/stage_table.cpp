#include <fmt/format.h>

#include <algorithm>
#include <cylpose/stage_table.hpp>

namespace cylpose {

void StageTable::add(std::span<const StageTime> frame) {
  std::vector<StageTime> sums;
  for (const StageTime& time : frame) {
    const auto sum = std::find_if(sums.begin(), sums.end(), [&](const StageTime& s) { return s.stage == time.stage; });
    if (sum == sums.end()) {
      sums.push_back(time);
    } else {
      sum->milliseconds += time.milliseconds;
    }
  }
  for (const StageTime& sum : sums) {
    auto stage = std::find_if(stages_.begin(), stages_.end(), [&](const auto& s) { return s.first == sum.stage; });
    if (stage == stages_.end()) stage = stages_.insert(stages_.end(), {sum.stage, {}});
    stage->second.push_back(sum.milliseconds);
  }
}

std::vector<StageSummary> StageTable::summaries() const {
  std::vector<StageSummary> all;
  all.reserve(stages_.size());
  for (const auto& [stage, milliseconds] : stages_) {
    all.push_back({std::string(stage), *statistics_of(milliseconds), milliseconds.size()});
  }
  return all;
}

std::string StageTable::text() const {
  std::string text = fmt::format("{:<20}{:>10}{:>10}{:>10}{:>8}\n", "stage [ms]", "mean", "median", "p95", "frames");
  for (const StageSummary& summary : summaries()) {
    const Statistics& statistics = summary.milliseconds;
    text += fmt::format("{:<20}{:>10.3f}{:>10.3f}{:>10.3f}{:>8}\n", summary.stage, statistics.mean, statistics.median,
                        statistics.p95, summary.frames);
  }
  return text;
}

}  // namespace cylpose
