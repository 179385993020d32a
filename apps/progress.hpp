// The progress bar on a terminal.
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string_view>

namespace cylpose::apps {

/// One line on standard error that is drawn over and over; shown only where standard error is a terminal that does not
/// also get the results.
class Progress {
 public:
  Progress(std::optional<std::int64_t> total, bool results_on_stdout);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  void update(std::int64_t done);

  /// A message on standard error, whether or not the bar is shown.
  void message(std::string_view text);

 private:
  void erase();

  std::optional<std::int64_t> total_;
  bool shown_;
  bool drawn_ = false;
  std::chrono::steady_clock::time_point start_;
  std::chrono::steady_clock::time_point last_drawn_;
};

}  // namespace cylpose::apps
