#include "opencl/strip_run.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cstring>
#include <cylpose/error.hpp>
#include <limits>
#include <memory>
#include <optional>
#include <thread>
#include <utility>

#include "channels.hpp"
#include "linear_light.hpp"

namespace cylpose::opencl {
namespace {

// Rows of the image around a strip that its kernels read: mask and response 4, lines through edges 14 (locate.cl).
constexpr int kGateHalo = 4;
constexpr int kImageHalo = 14;

constexpr int kWordBits = 64;
constexpr int kWordsAtOnce = 8;  // the kernels read planes in such blocks

std::size_t size_of(int count) {
  return static_cast<std::size_t>(count);
}

Kernel kernel_of(cl_program program, const char* name, std::string_view device) {
  cl_int code = CL_SUCCESS;
  Kernel kernel(clCreateKernel(program, name, &code));
  check(code, "clCreateKernel", device);
  return kernel;
}

template <typename... Args>
void set_arguments(const Kernel& kernel, std::string_view device, const Args&... args) {
  cl_uint index = 0;
  // NOLINTNEXTLINE(bugprone-sizeof-expression): handles are pointers, and the handle itself is the argument
  (check(clSetKernelArg(kernel.get(), index++, sizeof(Args), &args), "clSetKernelArg", device), ...);
}

constexpr int squared_sobel(int levels_per_pixel) {
  return 64 * levels_per_pixel * levels_per_pixel;
}

}  // namespace

void DeviceBuffer::reserve(const Device& device, std::size_t bytes) {
  if (bytes <= bytes_) return;
  memory_.reset();
  bytes_ = 0;
  cl_int code = CL_SUCCESS;
  Memory memory(clCreateBuffer(device.context(), CL_MEM_READ_WRITE, bytes, nullptr, &code));
  if (code != CL_SUCCESS) fail(fmt::format("clCreateBuffer of {} bytes", bytes), code, device.name());
  memory_ = std::move(memory);
  bytes_ = bytes;
}

StripRun::StripRun(Device& device) : device_(device) {
  cl_int code = CL_SUCCESS;
  queue_ = Queue(
      clCreateCommandQueue(device.context(), device.id(), device.profiles() ? CL_QUEUE_PROFILING_ENABLE : 0, &code));
  check(code, "clCreateCommandQueue", device.name());
}

template <typename Enqueue>
void StripRun::submit(Enqueue enqueue) {
  try {
    enqueue();
  } catch (...) {
    drain();
    throw;
  }
  // From here on only the callback tells that the device has stopped.
  busy_ = true;
  completion_.watch(end_.get(), device_.name());
  check(clFlush(queue_.get()), "clFlush", device_.name());
}

void StripRun::start(const StripTask& task) {
  timed_.clear();
  located_ = true;
  submit([&] {
    enqueue_finding(task);
    enqueue_locating(task.options.locate ? frame_.edge_capacity : 0);
    read_all();
  });
}

void StripRun::start_finding(const StripTask& task) {
  timed_.clear();
  located_ = false;
  submit([&] {
    enqueue_finding(task);
    read(0, frame_.rows_at);
  });
}

void StripRun::start_locating(std::span<const ColorSum> colors) {
  located_ = true;
  submit([&] {
    colors_.assign(colors.begin(), colors.end());
    check(clEnqueueWriteBuffer(queue_.get(), result_buffer_.get(), CL_FALSE, sizeof(ResultHeader), colors.size_bytes(),
                               colors_.data(), 0, nullptr, nullptr),
          "clEnqueueWriteBuffer", device_.name());
    enqueue_locating(frame_.edge_capacity);
    read_all();
  });
}

bool StripRun::wait() {
  wait_for_end();
  const std::size_t edges = header().edges;
  if (edges > edge_capacity_) {
    edge_capacity_ = edges + edges / 4;
    return false;
  }
  if (!located_) return true;
  if (header().stamp != frame_.stamp) {
    throw Error(ErrorKind::kDevice, device_.name() + " reported success, but its results are not of this frame");
  }
  if (edges > edges_read_) {
    const double milliseconds = milliseconds_;
    submit(
        [&] { read(frame_.edges_at + edges_read_ * sizeof(KernelEdge), (edges - edges_read_) * sizeof(KernelEdge)); });
    wait_for_end();
    milliseconds_ = milliseconds;
  }
  edges_before_ = edges;
  return true;
}

void StripRun::enqueue_finding(const StripTask& task) {
  make_kernels(task.image.format);
  describe(task);
  size_buffers(task);
  provide_image(task);
  provide_gates(task.gates);

  const cl_mem image = device_.zero_copy() ? host_image_.get() : own_image_.get();
  const cl_mem gates = gate_buffer_.get();
  const cl_mem planes = planes_.get();
  const cl_mem masks = masks_.get();
  const cl_mem result = result_buffer_.get();
  const cl_mem light = device_.light_tables();
  set_arguments(gate_, device_.name(), image, frame_, gates, planes, result);
  set_arguments(opening_, device_.name(), frame_, planes, masks, result);
  set_arguments(find_edges_, device_.name(), image, frame_, gates, light, masks, result);

  // Shares per core: as many as spread uneven rows evenly, as few as launches cost.
  const LaunchShape& shape = device_.shape();
  const std::size_t rows = size_of(frame_.end_row - frame_.first_row) * size_of(frame_.parts);
  const std::size_t spans = (size_of(frame_.pitch) + size_of(shape.span_words()) - 1) / size_of(shape.span_words());
  launch("gate", gate_, shape.items(size_of(frame_.plane_rows) * spans, 8));
  launch("opening", opening_, shape.items(rows, 4));
  launch("edges", find_edges_, shape.items(rows, 16));
  if (task.options.with_mask) {
    mask_words_.resize(size_of(frame_.parts) * size_of(frame_.plane_rows) * size_of(frame_.pitch));
    check(clEnqueueReadBuffer(queue_.get(), masks, CL_FALSE, 0, mask_words_.size() * sizeof(CylU64), mask_words_.data(),
                              0, nullptr, nullptr),
          "clEnqueueReadBuffer", device_.name());
  }
}

void StripRun::enqueue_locating(CylU32 most_edges) {
  // Without edges it leaves its stamp, which tells that all kernels have run.
  KernelFrame frame = frame_;
  frame.edge_capacity = most_edges;
  const cl_mem image = device_.zero_copy() ? host_image_.get() : own_image_.get();
  const cl_mem result = result_buffer_.get();
  const cl_mem light = device_.light_tables();
  set_arguments(locate_edges_, device_.name(), image, frame, light, result);
  launch("locate", locate_edges_, device_.shape().items(most_edges, 16));
}

void StripRun::describe(const StripTask& task) {
  const Roi& search = task.search;
  const int words = (search.width + kWordBits - 1) / kWordBits;
  const std::uint32_t stamp = frame_.stamp + 1;
  frame_ = {};
  frame_.origin_x = search.x;
  frame_.origin_y = search.y;
  frame_.width = search.width;
  frame_.height = search.height;
  frame_.image_row = std::max(task.first_row - kImageHalo, 0);
  frame_.plane_row = std::max(task.first_row - kGateHalo, 0);
  frame_.plane_rows = std::min(task.end_row + kGateHalo, search.height) - frame_.plane_row;
  frame_.first_row = task.first_row;
  frame_.end_row = task.end_row;
  frame_.pitch = (words + kWordsAtOnce - 1) / kWordsAtOnce * kWordsAtOnce;
  frame_.parts = static_cast<CylI32>(task.gates.size());
  frame_.weak = squared_sobel(task.options.edge_low);
  frame_.strong = squared_sobel(task.options.edge_high);
  frame_.light_table = task.options.transfer == Transfer::kSrgb ? 0 : static_cast<CylI32>(LinearTable{}.size());
  frame_.stamp = stamp == 0 ? 1 : stamp;  // the gate resets it to 0
}

void StripRun::size_buffers(const StripTask& task) {
  const std::size_t parts = task.gates.size();
  const std::size_t rows = size_of(task.end_row - task.first_row);
  // The outlines of parts that fill the strip.
  edge_capacity_ = std::max(edge_capacity_, 2 * parts * (size_of(task.search.width) + rows));
  const std::size_t rows_at = sizeof(ResultHeader) + parts * sizeof(ColorSum);
  const std::size_t edges_at = rows_at + parts * rows * sizeof(RowStatistics);
  const std::size_t bytes = edges_at + edge_capacity_ * sizeof(KernelEdge);
  if (bytes > std::numeric_limits<CylU32>::max()) {
    throw Error(ErrorKind::kDevice, fmt::format("{} parts in {} rows are too many at once for {}; use fewer parts",
                                                parts, rows, device_.name()));
  }
  frame_.rows_at = static_cast<CylU32>(rows_at);
  frame_.edges_at = static_cast<CylU32>(edges_at);
  frame_.edge_capacity = static_cast<CylU32>(edge_capacity_);

  const std::size_t plane_bytes = parts * size_of(frame_.plane_rows) * size_of(frame_.pitch) * sizeof(CylU64);
  planes_.reserve(device_, plane_bytes);
  masks_.reserve(device_, plane_bytes);
  result_buffer_.reserve(device_, bytes);
  result_.resize(bytes);
}

void StripRun::provide_image(const StripTask& task) {
  const int step = channels_of(task.image.format).step;
  const int end = std::min(task.end_row + kImageHalo, task.search.height);
  const std::size_t rows = size_of(end - frame_.image_row);
  const std::size_t row_bytes = size_of(task.search.width * step);
  const std::uint8_t* first =
      task.image.row(task.search.y + frame_.image_row) + static_cast<std::ptrdiff_t>(task.search.x) * step;
  if (device_.zero_copy()) {
    const auto stride = static_cast<std::size_t>(task.image.stride);
    const std::size_t bytes = (rows - 1) * stride + row_bytes;
    cl_int code = CL_SUCCESS;
    host_image_ = Memory(clCreateBuffer(device_.context(), CL_MEM_READ_ONLY | CL_MEM_USE_HOST_PTR, bytes,
                                        const_cast<std::uint8_t*>(first), &code));
    check(code, "clCreateBuffer", device_.name());
    frame_.image_stride = task.image.stride;
    return;
  }
  own_image_.reserve(device_, rows * row_bytes);
  frame_.image_stride = static_cast<CylI64>(row_bytes);
  const std::size_t origin[3] = {0, 0, 0};
  const std::size_t region[3] = {row_bytes, rows, 1};
  check(clEnqueueWriteBufferRect(queue_.get(), own_image_.get(), CL_FALSE, origin, origin, region, row_bytes, 0,
                                 static_cast<std::size_t>(task.image.stride), 0, first, 0, nullptr, timed("upload")),
        "clEnqueueWriteBufferRect", device_.name());
}

void StripRun::provide_gates(std::span<const KernelGate> gates) {
  if (gates.size() == gates_.size() && std::memcmp(gates.data(), gates_.data(), gates.size_bytes()) == 0) return;
  gates_.assign(gates.begin(), gates.end());
  gate_buffer_.reserve(device_, gates.size_bytes());
  check(clEnqueueWriteBuffer(queue_.get(), gate_buffer_.get(), CL_FALSE, 0, gates.size_bytes(), gates_.data(), 0,
                             nullptr, nullptr),
        "clEnqueueWriteBuffer", device_.name());
}

void StripRun::make_kernels(PixelFormat format) {
  if (gate_ && format == format_) return;
  const cl_program program = device_.program(format);
  gate_ = kernel_of(program, "gate", device_.name());
  opening_ = kernel_of(program, "opening", device_.name());
  find_edges_ = kernel_of(program, "find_edges", device_.name());
  locate_edges_ = kernel_of(program, "locate_edges", device_.name());
  format_ = format;
  compiled_ = false;
}

void StripRun::launch(std::string_view stage, const Kernel& kernel, std::size_t items) {
  const std::size_t group_size = device_.shape().group_size();
  const cl_int code =
      clEnqueueNDRangeKernel(queue_.get(), kernel.get(), 1, nullptr, &items, &group_size, 0, nullptr, timed(stage));
  if (code != CL_SUCCESS) fail(fmt::format("clEnqueueNDRangeKernel of '{}'", stage), code, device_.name());
}

void StripRun::read(std::size_t offset, std::size_t bytes) {
  check(clEnqueueReadBuffer(queue_.get(), result_buffer_.get(), CL_FALSE, offset, bytes, result_.data() + offset, 0,
                            nullptr, end_.out()),
        "clEnqueueReadBuffer", device_.name());
}

void StripRun::read_all() {
  // The edges that the frame before lets expect, and some more.
  constexpr std::size_t kSpare = 256;
  edges_read_ = std::min(edge_capacity_, edges_before_ + edges_before_ / 4 + kSpare);
  read(0, frame_.edges_at + edges_read_ * sizeof(KernelEdge));
}

void StripRun::when_done(std::function<void()> then) {
  // The driver or the watchdog, whoever comes first. A driver that comes late must not touch the watchdog: the device
  // may be gone by then.
  struct Once {
    std::atomic<bool> claimed = false;
    std::function<void()> then;
  };
  const auto once = std::make_shared<Once>();
  once->then = std::move(then);
  Watchdog& watchdog = device_.watchdog();
  const Watchdog::Ticket ticket = watchdog.add(completion_.start() + patience(), [once] {
    if (!once->claimed.exchange(true)) std::exchange(once->then, nullptr)();
  });
  completion_.when_ended([once, &watchdog, ticket] {
    if (once->claimed.exchange(true)) return;
    watchdog.dismiss(ticket);
    std::exchange(once->then, nullptr)();
  });
}

std::chrono::milliseconds StripRun::patience() const {
  // Some drivers compile when a kernel first runs.
  constexpr std::chrono::milliseconds kCompiling{120'000};
  return compiled_ ? device_.timeout() : std::max(device_.timeout(), kCompiling);
}

void StripRun::wait_for_end() {
  const std::chrono::milliseconds timeout = patience();
  const std::optional<cl_int> status = late_ ? std::nullopt : completion_.wait(timeout);
  late_ = !status;
  if (late_) {
    throw Error(ErrorKind::kDevice, fmt::format("{} did not answer within {} ms", device_.name(), timeout.count()));
  }
  busy_ = false;
  check(*status, "the run of the kernels", device_.name());
  milliseconds_ = compiled_ ? completion_.milliseconds() : 0;
  compiled_ = compiled_ || located_;
}

void StripRun::drain() {
  using Clock = std::chrono::steady_clock;
  constexpr std::chrono::milliseconds kPause{1};
  busy_ = true;
  Event marker;
  if (clEnqueueMarkerWithWaitList(queue_.get(), 0, nullptr, marker.out()) != CL_SUCCESS) return;
  if (clFlush(queue_.get()) != CL_SUCCESS) return;
  for (const auto end = Clock::now() + device_.timeout(); Clock::now() < end; std::this_thread::sleep_for(kPause)) {
    cl_int status = CL_QUEUED;
    const cl_int code =
        clGetEventInfo(marker.get(), CL_EVENT_COMMAND_EXECUTION_STATUS, sizeof status, &status, nullptr);
    if (code == CL_SUCCESS && status > CL_COMPLETE) continue;
    busy_ = code != CL_SUCCESS;
    return;
  }
}

cl_event* StripRun::timed(std::string_view stage) {
  if (!device_.profiles()) return nullptr;
  return timed_.emplace_back(TimedEvent{stage, Event()}).event.out();
}

const ResultHeader& StripRun::header() const {
  return *reinterpret_cast<const ResultHeader*>(result_.data());
}

std::span<const ColorSum> StripRun::colors() const {
  return {reinterpret_cast<const ColorSum*>(result_.data() + sizeof(ResultHeader)), size_of(frame_.parts)};
}

std::span<const RowStatistics> StripRun::rows(std::size_t part) const {
  const std::size_t count = size_of(frame_.end_row - frame_.first_row);
  const auto* all = reinterpret_cast<const RowStatistics*>(result_.data() + frame_.rows_at);
  return {all + part * count, count};
}

std::span<const KernelEdge> StripRun::edges() const {
  return {reinterpret_cast<const KernelEdge*>(result_.data() + frame_.edges_at), header().edges};
}

std::span<const CylU64> StripRun::mask_row(std::size_t part, int row) const {
  const std::size_t pitch = size_of(frame_.pitch);
  const std::size_t at = (part * size_of(frame_.plane_rows) + size_of(row - frame_.plane_row)) * pitch;
  return std::span(mask_words_).subspan(at, pitch);
}

std::vector<StageTime> StripRun::times() const {
  const auto moment = [&](const TimedEvent& timed, cl_profiling_info which) {
    cl_ulong nanoseconds = 0;
    check(clGetEventProfilingInfo(timed.event.get(), which, sizeof nanoseconds, &nanoseconds, nullptr),
          "clGetEventProfilingInfo", device_.name());
    return nanoseconds;
  };
  constexpr double kMilliseconds = 1e-6;  // of a nanosecond
  cl_ulong end = 0;
  for (const TimedEvent& timed : timed_) end = std::max(end, moment(timed, CL_PROFILING_COMMAND_END));
  std::vector<StageTime> times;
  for (const TimedEvent& timed : timed_) {
    const cl_ulong start = moment(timed, CL_PROFILING_COMMAND_START);
    times.push_back({timed.stage, static_cast<double>(moment(timed, CL_PROFILING_COMMAND_END) - start) * kMilliseconds,
                     static_cast<double>(end - start) * kMilliseconds});
  }
  return times;
}

}  // namespace cylpose::opencl
