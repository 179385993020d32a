#include "opencl/team.hpp"

#include <algorithm>
#include <atomic>
#include <cylpose/error.hpp>
#include <utility>

namespace cylpose::opencl {
namespace {

// For jobs that a device may still be using. Never destroyed, not even at the end of the process: a late device would
// write into memory that is somebody else's by then.
void keep_for_ever(std::unique_ptr<StripJob> job) {
  static std::mutex mutex;
  static auto* const kept = new std::vector<std::unique_ptr<StripJob>>;
  const std::scoped_lock lock(mutex);
  kept->push_back(std::move(job));
}

StripTask strip_of(const StripTask& frame, int first_row, int end_row) {
  StripTask strip = frame;
  strip.first_row = first_row;
  strip.end_row = end_row;
  return strip;
}

std::vector<ColorSum> summed(const std::vector<ColorSum>& a, std::span<const ColorSum> b) {
  std::vector<ColorSum> sums(a);
  for (std::size_t part = 0; part < sums.size(); ++part) {
    for (std::size_t i = 0; i < std::size(sums[part].low); ++i) {
      const auto value = [i](const ColorSum& sum) { return CylU64{sum.high[i]} << 32 | sum.low[i]; };
      const CylU64 total = value(sums[part]) + value(b[part]);
      sums[part].low[i] = static_cast<CylU32>(total);
      sums[part].high[i] = static_cast<CylU32>(total >> 32);
    }
  }
  return sums;
}

}  // namespace

JobLease& JobLease::operator=(JobLease&& other) noexcept {
  if (this != &other) {
    end();
    worker_ = other.worker_;
    job_ = std::move(other.job_);
  }
  return *this;
}

void JobLease::end() {
  if (job_ == nullptr || !job_->busy()) return;
  // Another strip failed, or this one did: the caller's image must not be in use when he gets it back.
  try {
    static_cast<void>(job_->wait());
  } catch (const Error&) {
    // Whatever it was, busy() tells what matters now.
  }
  if (job_->busy()) keep_for_ever(std::move(job_));
}

Team::Team(const std::vector<Worker*>& workers, int strip_rows, Lost lost)
    : strip_rows_(strip_rows), lost_(std::move(lost)) {
  constexpr double kPixelsPerMsAndUnit = 1e6;  // until measured; only the ratio between devices matters
  for (Worker* worker : workers) members_.push_back({worker, kPixelsPerMsAndUnit * worker->compute_units()});
}

std::vector<Team::Attempt> Team::planned(const StripTask& frame) {
  // Below this time on the fastest device the second wait costs more than the others save.
  constexpr double kWorthSharingMs = 0.4;
  constexpr int kLeastRows = 16;  // halos make thinner strips a waste

  const std::scoped_lock lock(mutex_);
  std::vector<std::size_t> present;
  double total_speed = 0;
  std::size_t best = 0;
  for (std::size_t i = 0; i < members_.size(); ++i) {
    if (members_[i].lost) continue;
    if (present.empty() || members_[i].pixels_per_ms > members_[best].pixels_per_ms) best = i;
    present.push_back(i);
    total_speed += members_[i].pixels_per_ms;
  }
  const auto attempt = [&](int first, int end, std::size_t member) {
    return Attempt{{strip_of(frame, first, end), JobLease()}, member, {}};
  };
  if (present.empty()) {
    throw Error(ErrorKind::kDevice, "all OpenCL devices have failed before; make a new backend");
  }
  std::vector<Attempt> plan;
  const int rows = frame.end_row - frame.first_row;
  if (strip_rows_ > 0) {
    for (int row = frame.first_row; row < frame.end_row; row += strip_rows_) {
      plan.push_back(attempt(row, std::min(row + strip_rows_, frame.end_row), present[plan.size() % present.size()]));
    }
    return plan;
  }
  const double pixels = static_cast<double>(rows) * frame.search.width;
  const int sharers = static_cast<int>(present.size());
  if (sharers < 2 || rows < 2 * sharers * kLeastRows || pixels < kWorthSharingMs * members_[best].pixels_per_ms) {
    plan.push_back(attempt(frame.first_row, frame.end_row, best));
    return plan;
  }
  double speed_before = 0;
  int first = frame.first_row;
  for (int i = 0; i < sharers; ++i) {
    // Everybody gets a few rows, so that everybody's speed is known.
    speed_before += members_[present[static_cast<std::size_t>(i)]].pixels_per_ms;
    const int ideal = frame.first_row + static_cast<int>(rows * speed_before / total_speed);
    const int latest = frame.end_row - (sharers - 1 - i) * kLeastRows;
    const int end = i + 1 == sharers ? frame.end_row : std::clamp(ideal, first + kLeastRows, latest);
    plan.push_back(attempt(first, end, present[static_cast<std::size_t>(i)]));
    first = end;
  }
  return plan;
}

std::size_t Team::fastest(const std::string& last_failure) const {
  const std::scoped_lock lock(mutex_);
  const Member* best = nullptr;
  for (const Member& member : members_) {
    if (!member.lost && (best == nullptr || member.pixels_per_ms > best->pixels_per_ms)) best = &member;
  }
  if (best == nullptr) {
    throw Error(ErrorKind::kDevice, "the last OpenCL device that was left failed as well: " + last_failure);
  }
  return static_cast<std::size_t>(best - members_.data());
}

void Team::give_up(std::size_t member, const std::string& why) {
  {
    const std::scoped_lock lock(mutex_);
    if (members_.size() == 1) throw Error(ErrorKind::kDevice, why);
    if (std::exchange(members_[member].lost, true)) return;
  }
  if (lost_) lost_(member, why);
}

void Team::note_speed(const Attempt& attempt) {
  constexpr double kWeight = 0.2;  // of the newest measurement
  const double milliseconds = attempt.strip.lease.job().milliseconds();
  if (milliseconds <= 0) return;
  const StripTask& task = attempt.strip.task;
  const double speed = static_cast<double>(task.end_row - task.first_row) * task.search.width / milliseconds;
  const std::scoped_lock lock(mutex_);
  double& known = members_[attempt.member].pixels_per_ms;
  known += kWeight * (speed - known);
}

void Team::try_start(Attempt& attempt, const Start& start) {
  try {
    start(attempt.strip.lease.job(), attempt.strip.task);
  } catch (const Error& error) {
    if (error.kind() != ErrorKind::kDevice) throw;
    attempt.failure = error.what();
  }
}

void Team::begin(Attempt& attempt, const Start& start) {
  attempt.strip.lease = JobLease(*members_[attempt.member].worker);
  try_start(attempt, start);
}

// Waits; where that fails, and where the start has failed already, somebody else does the strip from the beginning.
void Team::finish(Attempt& attempt, const Start& start_anew) {
  for (;;) {
    if (attempt.failure.empty()) {
      try {
        while (!attempt.strip.lease.job().wait()) start_anew(attempt.strip.lease.job(), attempt.strip.task);
        return;
      } catch (const Error& error) {
        if (error.kind() != ErrorKind::kDevice) throw;
        attempt.failure = error.what();
      }
    }
    give_up(attempt.member, attempt.failure);
    attempt.member = fastest(std::exchange(attempt.failure, {}));
    begin(attempt, start_anew);
  }
}

Team::Run Team::start(const StripTask& frame) {
  Run run;
  run.attempts_ = planned(frame);
  run.parts_ = frame.gates.size();
  run.in_one_step_ = run.attempts_.size() == 1 || !frame.options.locate;
  const Start first_step = [&run](StripJob& job, const StripTask& task) {
    run.in_one_step_ ? job.start(task) : job.start_finding(task);
  };
  for (Attempt& attempt : run.attempts_) begin(attempt, first_step);
  return run;
}

void Team::Run::when_done(std::function<void()> then) const {
  struct Countdown {
    std::atomic<std::size_t> left;
    std::function<void()> then;
    void count() {
      if (--left == 0) then();
    }
  };
  const auto countdown = std::make_shared<Countdown>();
  // One more for this loop: the last one to count may end the run.
  countdown->left = attempts_.size() + 1;
  countdown->then = std::move(then);
  for (const Attempt& attempt : attempts_) {
    if (attempt.failure.empty()) {
      attempt.strip.lease.job().when_done([countdown] { countdown->count(); });
    } else {
      countdown->count();
    }
  }
  countdown->count();
}

std::vector<DoneStrip> Team::finish(Run run) {
  std::vector<Attempt>& attempts = run.attempts_;
  if (run.in_one_step_) {
    for (Attempt& attempt : attempts) {
      finish(attempt, [](StripJob& job, const StripTask& task) { job.start(task); });
      note_speed(attempt);
    }
  } else {
    const Start find = [](StripJob& job, const StripTask& task) { job.start_finding(task); };
    std::vector<ColorSum> colors(run.parts_);
    for (Attempt& attempt : attempts) {
      finish(attempt, find);
      note_speed(attempt);
      colors = summed(colors, attempt.strip.lease.job().colors());
    }
    const Start locate = [&](StripJob& job, const StripTask&) { job.start_locating(colors); };
    const Start find_and_locate = [&](StripJob& job, const StripTask& task) {
      do job.start_finding(task);
      while (!job.wait());
      job.start_locating(colors);
    };
    for (Attempt& attempt : attempts) try_start(attempt, locate);
    for (Attempt& attempt : attempts) finish(attempt, find_and_locate);
  }
  std::vector<DoneStrip> done;
  done.reserve(attempts.size());
  for (Attempt& attempt : attempts) done.push_back(std::move(attempt.strip));
  return done;
}

}  // namespace cylpose::opencl
