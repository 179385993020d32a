// A strip of a frame, the work to be done on it, and who does it: what a team needs to know of its devices.
#pragma once

#include <cylpose_types.h>

#include <cylpose/backend.hpp>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace cylpose::opencl {

struct StripTask {
  ImageView image;
  Roi search;     ///< lies in the image, not empty
  int first_row;  ///< rows of `search` to do, from its first row
  int end_row;
  std::span<const KernelGate> gates;  ///< one per part, at least one
  DetectOptions options;
};

/// Most parts in one task: KernelEdge::kind has room for no more.
inline constexpr std::size_t kMostParts = 2047;

/// Does one strip at a time. Either all at once: start, wait; or in two steps, because the place of an edge depends on
/// the part's colour in all strips: start_finding, wait, start_locating with the sum of all colors(), wait.
/// The start functions do not wait. All throw Error(kDevice).
class StripJob {
 public:
  virtual ~StripJob() = default;
  StripJob() = default;
  StripJob(const StripJob&) = delete;
  StripJob& operator=(const StripJob&) = delete;

  virtual void start(const StripTask& task) = 0;
  virtual void start_finding(const StripTask& task) = 0;
  virtual void start_locating(std::span<const ColorSum> colors) = 0;

  /// Waits for what was started. False when there were more edges than room for them: there is more now, start again.
  [[nodiscard]] virtual bool wait() = 0;

  /// Calls `then` once, when wait() will not wait for what was started: it has ended, or is late. At once or from
  /// another thread, which is not held up for long. Must not throw.
  virtual void when_done(std::function<void()> then) = 0;

  /// Whether the device may still be using the image and the job's memory.
  [[nodiscard]] virtual bool busy() const = 0;

  /// How long the device took for what was last waited for; 0 where that says nothing about its speed.
  [[nodiscard]] virtual double milliseconds() const = 0;

  // Results, valid until the next start.
  [[nodiscard]] virtual std::span<const ColorSum> colors() const = 0;
  [[nodiscard]] virtual std::span<const RowStatistics> rows(std::size_t part) const = 0;
  [[nodiscard]] virtual std::span<const KernelEdge> edges() const = 0;
  /// Words of a row of the strip; only with DetectOptions::with_mask.
  [[nodiscard]] virtual std::span<const CylU64> mask_row(std::size_t part, int row) const = 0;
  /// Device times, where the device profiles.
  [[nodiscard]] virtual std::vector<StageTime> times() const = 0;
};

/// A device. Any thread may call.
class Worker {
 public:
  virtual ~Worker() = default;
  Worker() = default;
  Worker(const Worker&) = delete;
  Worker& operator=(const Worker&) = delete;

  [[nodiscard]] virtual int compute_units() const = 0;
  /// A job that nobody else uses.
  [[nodiscard]] virtual std::unique_ptr<StripJob> take_job() = 0;
  virtual void give_back(std::unique_ptr<StripJob> job) = 0;
};

}  // namespace cylpose::opencl
