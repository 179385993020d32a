// One strip of one frame on one device: queue, kernels and buffers, kept from frame to frame.
#pragma once

#include <cylpose_types.h>

#include <cstddef>
#include <cylpose/backend.hpp>
#include <span>
#include <string_view>
#include <vector>

#include "opencl/api.hpp"
#include "opencl/completion.hpp"
#include "opencl/device.hpp"
#include "opencl/strip_job.hpp"

namespace cylpose::opencl {

/// Device memory that grows and never shrinks.
class DeviceBuffer {
 public:
  /// Contents are lost when it grows.
  void reserve(const Device& device, std::size_t bytes);
  [[nodiscard]] cl_mem get() const { return memory_.get(); }

 private:
  Memory memory_;
  std::size_t bytes_ = 0;
};

class StripRun final : public StripJob {
 public:
  explicit StripRun(Device& device);

  void start(const StripTask& task) override;
  void start_finding(const StripTask& task) override;
  void start_locating(std::span<const ColorSum> colors) override;
  [[nodiscard]] bool wait() override;
  void when_done(std::function<void()> then) override;
  [[nodiscard]] bool busy() const override { return busy_; }
  [[nodiscard]] double milliseconds() const override { return milliseconds_; }

  [[nodiscard]] std::span<const ColorSum> colors() const override;
  [[nodiscard]] std::span<const RowStatistics> rows(std::size_t part) const override;
  [[nodiscard]] std::span<const KernelEdge> edges() const override;
  [[nodiscard]] std::span<const CylU64> mask_row(std::size_t part, int row) const override;
  [[nodiscard]] std::vector<StageTime> times() const override;

 private:
  struct TimedEvent {
    std::string_view stage;
    Event event;
  };

  template <typename Enqueue>
  void submit(Enqueue enqueue);
  void enqueue_finding(const StripTask& task);
  void enqueue_locating(CylU32 most_edges);
  void describe(const StripTask& task);
  void size_buffers(const StripTask& task);
  void provide_image(const StripTask& task);
  void provide_gates(std::span<const KernelGate> gates);
  void make_kernels(PixelFormat format);
  void launch(std::string_view stage, const Kernel& kernel, std::size_t items);
  void read(std::size_t offset, std::size_t bytes);
  void read_all();
  [[nodiscard]] std::chrono::milliseconds patience() const;
  void wait_for_end();
  void drain();
  [[nodiscard]] cl_event* timed(std::string_view stage);
  [[nodiscard]] const ResultHeader& header() const;

  Device& device_;
  Queue queue_;
  Completion completion_;
  Event end_;
  bool busy_ = false;
  bool late_ = false;        ///< the device did not answer in time
  bool compiled_ = false;    ///< the kernels have run before
  double milliseconds_ = 0;  ///< of the last wait; 0 when that may have compiled
  bool located_ = false;     ///< what was started ends with locate_edges

  PixelFormat format_{};
  Kernel gate_;
  Kernel opening_;
  Kernel find_edges_;
  Kernel locate_edges_;

  KernelFrame frame_{};
  Memory host_image_;  ///< the image where it lies
  DeviceBuffer own_image_;
  DeviceBuffer gate_buffer_;
  std::vector<KernelGate> gates_;  ///< what gate_buffer_ holds
  std::vector<ColorSum> colors_;   ///< on their way to the device
  DeviceBuffer planes_;
  DeviceBuffer masks_;
  DeviceBuffer result_buffer_;
  std::vector<std::byte> result_;
  std::vector<CylU64> mask_words_;
  std::size_t edge_capacity_ = 0;  ///< room in the result
  std::size_t edges_read_ = 0;     ///< read along with the rest; if there are more, they need a second read
  std::size_t edges_before_ = 0;   ///< found in the last frame: about what to expect
  std::vector<TimedEvent> timed_;
};

}  // namespace cylpose::opencl
