#include "progress.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <string>

namespace cylpose::apps {

using Clock = std::chrono::steady_clock;

Progress::Progress(std::optional<std::int64_t> total, bool results_on_stdout)
    : total_(total),
      shown_(isatty(STDERR_FILENO) != 0 && !(results_on_stdout && isatty(STDOUT_FILENO) != 0)),
      start_(Clock::now()),
      last_drawn_(start_) {}

Progress::~Progress() {
  erase();
}

void Progress::update(std::int64_t done) {
  constexpr std::chrono::milliseconds kPause(100);
  const Clock::time_point now = Clock::now();
  if (!shown_ || now - last_drawn_ < kPause) return;
  last_drawn_ = now;
  const double rate = static_cast<double>(done) / std::chrono::duration<double>(now - start_).count();
  std::string line;
  if (total_ && *total_ > 0) {
    constexpr int kWidth = 30;
    const double share = std::min(1.0, static_cast<double>(done) / static_cast<double>(*total_));
    const auto filled = static_cast<std::size_t>(share * kWidth);
    line = fmt::format("[{}{}] {}/{} {:3.0f} %  {:.1f} frames/s", std::string(filled, '#'),
                       std::string(kWidth - filled, '.'), done, *total_, 100 * share, rate);
  } else {
    line = fmt::format("{} frames  {:.1f} frames/s", done, rate);
  }
  fmt::print(stderr, "\r\x1b[K{}", line);
  drawn_ = true;
}

void Progress::message(std::string_view text) {
  erase();
  fmt::print(stderr, "cylpose: {}\n", text);
}

void Progress::erase() {
  if (drawn_) fmt::print(stderr, "\r\x1b[K");
  drawn_ = false;
}

}  // namespace cylpose::apps
