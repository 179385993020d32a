// A device in use: its context, its programs and the runs that wait for the next frame.
#pragma once

#include <chrono>
#include <cylpose/opencl_devices.hpp>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "opencl/api.hpp"
#include "opencl/device_list.hpp"
#include "opencl/program.hpp"
#include "opencl/strip_job.hpp"
#include "opencl/watchdog.hpp"

namespace cylpose::opencl {

/// How many work-items the kernels get.
class LaunchShape {
 public:
  LaunchShape(const OpenclDevice& device, const OpenclOptions& options);

  [[nodiscard]] std::size_t group_size() const { return group_size_; }
  [[nodiscard]] int span_words() const { return span_words_; }

  /// Work-items for `units` pieces of work, of which a CPU's core should get at least `shares`.
  [[nodiscard]] std::size_t items(std::size_t units, std::size_t shares) const;

 private:
  bool cpu_;
  std::size_t cores_;
  std::size_t group_size_;
  int span_words_;
};

class Device final : public Worker {
 public:
  Device(LocalDevice device, const OpenclOptions& options);
  ~Device() override;

  [[nodiscard]] const OpenclDevice& info() const { return info_; }
  [[nodiscard]] const std::string& name() const { return target_.device_name; }
  [[nodiscard]] cl_context context() const { return context_.get(); }
  [[nodiscard]] cl_device_id id() const { return target_.device; }
  [[nodiscard]] const LaunchShape& shape() const { return shape_; }
  [[nodiscard]] bool profiles() const { return profile_; }
  [[nodiscard]] std::chrono::milliseconds timeout() const { return timeout_; }

  /// Whether the kernels read frames where they lie, because that is quicker than a copy.
  [[nodiscard]] bool zero_copy() const { return zero_copy_; }

  /// Of the runs that nobody waits for.
  [[nodiscard]] Watchdog& watchdog() { return watchdog_; }

  /// Light of each code, for sRGB and then for linear codes.
  [[nodiscard]] cl_mem light_tables() const { return light_tables_.get(); }

  /// Built at the first use. Any thread.
  [[nodiscard]] cl_program program(PixelFormat format);

  [[nodiscard]] int compute_units() const override { return info_.compute_units; }
  [[nodiscard]] std::unique_ptr<StripJob> take_job() override;
  void give_back(std::unique_ptr<StripJob> job) override;

 private:
  SubDevice part_;
  OpenclDevice info_;
  LaunchShape shape_;
  bool profile_;
  std::chrono::milliseconds timeout_;
  std::optional<ProgramCache> cache_;
  Context context_;
  ProgramTarget target_;
  Memory light_tables_;
  bool zero_copy_;

  std::mutex program_mutex_;
  std::map<PixelFormat, Program> programs_;
  Watchdog watchdog_;
  std::mutex job_mutex_;
  std::vector<std::unique_ptr<StripJob>> idle_jobs_;
};

}  // namespace cylpose::opencl
