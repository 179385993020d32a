// Several devices on one frame: strips by measured speed, and none lost when a device fails.
#pragma once

#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "opencl/strip_job.hpp"

namespace cylpose::opencl {

/// A job in use. What went well goes back to its worker; what the device may still be using is kept for ever.
class JobLease {
 public:
  JobLease() = default;
  explicit JobLease(Worker& worker) : worker_(&worker), job_(worker.take_job()) {}
  JobLease(JobLease&&) = default;
  JobLease& operator=(JobLease&& other) noexcept;
  JobLease(const JobLease&) = delete;
  JobLease& operator=(const JobLease&) = delete;
  ~JobLease() { end(); }

  [[nodiscard]] StripJob& job() const { return *job_; }
  void succeed() { worker_->give_back(std::move(job_)); }

 private:
  void end();

  Worker* worker_ = nullptr;
  std::unique_ptr<StripJob> job_;
};

/// A strip with its results.
struct DoneStrip {
  StripTask task;
  JobLease lease;
};

class Team {
  struct Attempt {
    DoneStrip strip;
    std::size_t member;
    std::string failure;  ///< why the start failed; empty when it did not
  };

 public:
  /// A frame that the devices are at work on. Destroyed early, it waits until they have left the frame alone.
  class Run {
   public:
    /// Calls `then` once, when all that was started has ended or is late; as StripJob::when_done.
    void when_done(std::function<void()> then) const;

   private:
    friend class Team;
    std::vector<Attempt> attempts_;
    std::size_t parts_ = 0;
    bool in_one_step_ = true;  // each strip by itself: nothing is shared between finding and locating
  };

  /// Called once for each worker that is given up, with its index and the reason; from the thread that calls run().
  using Lost = std::function<void(std::size_t worker, const std::string& why)>;

  /// `strip_rows`: 0, or that many rows a strip whatever the speed. At least one worker.
  Team(const std::vector<Worker*>& workers, int strip_rows, Lost lost);

  /// Starts a whole frame. What `frame` points to must live until the run is finished or destroyed.
  /// Throws Error(kDevice) when nobody is left. Any thread.
  [[nodiscard]] Run start(const StripTask& frame);

  /// Waits for the rest: with one strip for nothing after Run::when_done, except where there were more edges than room;
  /// with several for the second step. The strips come from top to bottom. A worker that fails is given up, and the
  /// others do its strips. Throws Error(kDevice) when nobody is left. Any thread. A team of one never gives up its only
  /// worker.
  [[nodiscard]] std::vector<DoneStrip> finish(Run run);

 private:
  struct Member {
    Worker* worker;
    double pixels_per_ms;
    bool lost = false;
  };
  using Start = std::function<void(StripJob& job, const StripTask& task)>;

  [[nodiscard]] std::vector<Attempt> planned(const StripTask& frame);
  [[nodiscard]] std::size_t fastest(const std::string& last_failure) const;
  void try_start(Attempt& attempt, const Start& start);
  void begin(Attempt& attempt, const Start& start);
  void finish(Attempt& attempt, const Start& start_anew);
  void give_up(std::size_t member, const std::string& why);
  void note_speed(const Attempt& attempt);

  int strip_rows_;
  Lost lost_;
  mutable std::mutex mutex_;
  std::vector<Member> members_;
};

}  // namespace cylpose::opencl
