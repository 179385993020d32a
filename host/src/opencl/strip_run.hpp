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
inline constexpr std::size_t kMostParts = 16383;

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

class StripRun {
 public:
  explicit StripRun(Device& device);

  /// Sends all commands for a strip without waiting. The image and the gates must stay until wait() returns true.
  /// Throws Error(kDevice); then abandoned() tells whether the device may still be using them.
  void start(const StripTask& task);

  /// Waits until the device is done. False when there were more edges than there was room for: there is more now, start
  /// again. Throws Error(kDevice) when the device failed or was late.
  [[nodiscard]] bool wait();

  /// After an error: the device did not say that it has stopped. The run must then be kept for ever.
  [[nodiscard]] bool abandoned() const { return abandoned_; }

  // Results, valid until the next start().
  [[nodiscard]] std::span<const RowStatistics> rows(std::size_t part) const;
  [[nodiscard]] std::span<const KernelEdge> edges() const;
  /// Words of the rows of the strip; only with DetectOptions::with_mask.
  [[nodiscard]] std::span<const CylU64> mask_row(std::size_t part, int row) const;
  /// Device times, only where the device profiles.
  [[nodiscard]] std::vector<StageTime> times() const;

 private:
  struct TimedEvent {
    std::string_view stage;
    Event event;
  };

  void enqueue(const StripTask& task);
  void describe(const StripTask& task);
  void size_buffers(const StripTask& task);
  void provide_image(const StripTask& task);
  void provide_gates(std::span<const KernelGate> gates);
  void make_kernels(PixelFormat format);
  void launch(std::string_view stage, const Kernel& kernel, std::size_t items);
  void read_result();
  void read_edges_from(std::size_t first, std::size_t end);
  void submit();
  void wait_for_end();
  void drain();
  [[nodiscard]] cl_event* timed(std::string_view stage);
  [[nodiscard]] const ResultHeader& header() const;

  Device& device_;
  Queue queue_;
  Completion completion_;
  Event end_;
  bool abandoned_ = false;

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
