// How long each stage takes, over all frames.
#pragma once

#include <cylpose/edge_field.hpp>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace cylpose::apps {

class StageTable {
 public:
  /// The times of one frame; a stage that ran several times in it counts once, with the sum.
  void add(std::span<const StageTime> frame);

  /// Mean, median and 95th percentile of each stage in milliseconds, in the order of their first appearance.
  [[nodiscard]] std::string text() const;

 private:
  std::vector<std::pair<std::string_view, std::vector<double>>> stages_;
};

}  // namespace cylpose::apps
