// The kernels of kernels/ behind the Backend interface.
#include <algorithm>
#include <array>
#include <cylpose/error.hpp>
#include <cylpose/gate.hpp>
#include <cylpose/opencl_devices.hpp>
#include <utility>

#include "builtin_backends.hpp"
#include "opencl/device.hpp"
#include "opencl/device_list.hpp"
#include "opencl/results.hpp"
#include "opencl/strip_run.hpp"
#include "option_check.hpp"
#include "stage_clock.hpp"

namespace cylpose {
namespace {

using opencl::KernelGate;
using opencl::StripRun;
using opencl::StripTask;

// The hue test without branches: lo.p >= 0 and hi.p <= 0 as two sums that must not be negative; for a wide range its
// complement, lo.p < 0 and hi.p > 0; for any hue two sums of nothing.
KernelGate kernel_gate(const ColorGate& gate) {
  const bool wide = gate.wide != 0;
  const int sign = gate.any_hue != 0 ? 0 : wide ? -1 : 1;
  KernelGate result{};
  result.a_r = sign * gate.lo_r;
  result.a_b = sign * gate.lo_b;
  result.b_r = -sign * gate.hi_r;
  result.b_b = -sign * gate.hi_b;
  result.bias = sign < 0 ? -1 : 0;
  result.invert = sign < 0 ? 1 : 0;
  result.any_hue = gate.any_hue;
  result.saturation_256 = gate.saturation_256;
  result.value = gate.value;
  result.response_r = gate.response_r;
  result.response_b = gate.response_b;
  return result;
}

// A run for one call. What went well goes back to the device; what the device may still be using is kept for ever.
class RunLease {
 public:
  explicit RunLease(opencl::Device& device) : device_(device), run_(device.take_run()) {}
  RunLease(const RunLease&) = delete;
  RunLease& operator=(const RunLease&) = delete;
  ~RunLease() {
    if (run_ != nullptr && run_->abandoned()) opencl::keep_for_ever(std::move(run_));
  }

  [[nodiscard]] StripRun& run() { return *run_; }
  void succeed() { device_.give_back(std::move(run_)); }

 private:
  opencl::Device& device_;
  std::unique_ptr<StripRun> run_;
};

class DeviceBackend final : public OpenclBackend {
 public:
  explicit DeviceBackend(const OpenclOptions& options)
      : device_(std::make_shared<opencl::Device>(opencl::chosen_device(options.device), options)) {}

  [[nodiscard]] std::string_view name() const override { return "opencl"; }
  [[nodiscard]] std::vector<OpenclDevice> devices() const override { return {device_->info()}; }

  [[nodiscard]] EdgeField detect(const ImageView& image, const Roi& search, std::span<const PartModel> parts,
                                 const DetectOptions& options) override {
    EdgeField field;
    field.searched = usable_search(image, search, options);
    field.parts.resize(parts.size());
    if (parts.size() > opencl::kMostParts) {
      throw Error(ErrorKind::kInput, std::to_string(parts.size()) +
                                         " parts are too many for the opencl backend; at most " +
                                         std::to_string(opencl::kMostParts));
    }
    if (parts.empty()) return field;
    if (field.searched.empty()) {
      if (options.with_mask) {
        for (PartEdges& part : field.parts) part.mask.roi = field.searched;
      }
      return field;
    }
    std::vector<KernelGate> gates;
    gates.reserve(parts.size());
    for (const PartModel& part : parts) gates.push_back(kernel_gate(make_gate(part)));

    StageClock clock;
    RunLease lease(*device_);
    StripRun& run = lease.run();
    const StripTask task{image, field.searched, 0, field.searched.height, gates, options};
    do {
      run.start(task);
      clock.lap("enqueue");
    } while (!run.wait());
    clock.lap("wait");
    opencl::collect(run, task, field);
    clock.lap("collect");
    field.times = device_->profiles() ? run.times() : clock.times();
    lease.succeed();
    return field;
  }

 private:
  std::shared_ptr<opencl::Device> device_;
};

}  // namespace

bool OpenclOptions::is_valid(std::string* why) const {
  return require_positive(static_cast<double>(timeout.count()), "timeout in ms", why) &&
         require_at_least(group_size, 0, "group_size", why) && require_at_least(span_words, 0, "span_words", why);
}

std::vector<OpenclDevice> opencl_devices() {
  std::vector<OpenclDevice> devices;
  for (const opencl::LocalDevice& device : opencl::local_devices()) devices.push_back(device.info);
  return devices;
}

std::unique_ptr<OpenclBackend> make_opencl_backend(const OpenclOptions& options) {
  if (std::string why; !options.is_valid(&why)) {
    throw Error(ErrorKind::kInput, "options of the opencl backend: " + why);
  }
  return std::make_unique<DeviceBackend>(options);
}

std::unique_ptr<Backend> make_default_opencl_backend() {
  return make_opencl_backend();
}

}  // namespace cylpose
