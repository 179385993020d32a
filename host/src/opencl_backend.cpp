// The kernels of kernels/ behind the Backend interface.
#include <algorithm>
#include <cylpose/error.hpp>
#include <cylpose/gate.hpp>
#include <cylpose/opencl_devices.hpp>
#include <exception>
#include <memory>
#include <optional>
#include <utility>

#include "builtin_backends.hpp"
#include "opencl/device.hpp"
#include "opencl/device_list.hpp"
#include "opencl/kernel_source.hpp"
#include "opencl/results.hpp"
#include "opencl/team.hpp"
#include "option_check.hpp"
#include "stage_clock.hpp"

namespace cylpose {
namespace {

using opencl::KernelGate;

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
  result.aside_r = gate.aside_r;
  result.aside_b = gate.aside_b;
  return result;
}

// One frame from the start of its kernels to its edge field.
class DeviceDetection final : public DetectionEnd {
 public:
  // Starts; a failure comes out of field().
  DeviceDetection(opencl::Team& team, const DetectRequest& request, bool profile) : team_(team), profile_(profile) {
    try {
      start(request);
    } catch (...) {
      failure_ = std::current_exception();
    }
  }

  // Where nothing was started, nothing ends: at once.
  void when_done(std::function<void()> then) const {
    if (run_) {
      run_->when_done(std::move(then));
    } else {
      then();
    }
  }

  [[nodiscard]] EdgeField field() override {
    if (failure_) std::rethrow_exception(failure_);
    if (!run_) return std::move(field_);
    std::vector<opencl::DoneStrip> strips = team_.finish(*std::exchange(run_, std::nullopt));
    clock_.lap("devices");
    opencl::collect(strips, field_);
    for (opencl::DoneStrip& strip : strips) strip.lease.succeed();
    clock_.lap("collect");
    if (!profile_) field_.times = clock_.times();
    return std::move(field_);
  }

 private:
  void start(const DetectRequest& request) {
    field_.searched = usable_search(request.image, request.search, request.options);
    field_.parts.resize(request.parts.size());
    if (request.parts.size() > opencl::kMostParts) {
      throw Error(ErrorKind::kInput, std::to_string(request.parts.size()) +
                                         " parts are too many for the opencl backend; at most " +
                                         std::to_string(opencl::kMostParts));
    }
    if (request.parts.empty()) return;
    const int end_row = std::min(request.options.rows.end, field_.searched.height);
    const int first_row = std::min(request.options.rows.first, end_row);
    if (field_.searched.empty() || first_row == end_row) {
      if (request.options.with_mask) {
        for (PartEdges& part : field_.parts) part.mask.roi = field_.searched;
      }
      return;
    }
    gates_.reserve(request.parts.size());
    for (const PartModel& part : request.parts) gates_.push_back(kernel_gate(make_gate(part)));
    clock_.skip();
    run_ = team_.start({request.image, field_.searched, first_row, end_row, gates_, request.options});
  }

  opencl::Team& team_;
  bool profile_;
  EdgeField field_;
  std::vector<KernelGate> gates_;  // the run reads them
  StageClock clock_;
  std::exception_ptr failure_;
  std::optional<opencl::Team::Run> run_;
};

class DeviceBackend final : public OpenclBackend {
 public:
  explicit DeviceBackend(const OpenclOptions& options)
      : profile_(options.profile),
        devices_(made_devices(options)),
        team_(workers(), options.strip_rows,
              [this, lost = options.on_device_lost](std::size_t i, const std::string& why) {
                if (lost) lost(devices_[i]->info(), why);
              }) {}

  [[nodiscard]] std::string_view name() const override { return "opencl"; }

  [[nodiscard]] std::vector<OpenclDevice> devices() const override {
    std::vector<OpenclDevice> infos;
    for (const auto& device : devices_) infos.push_back(device->info());
    return infos;
  }

  [[nodiscard]] EdgeField detect(const ImageView& image, const Roi& search, std::span<const PartModel> parts,
                                 const DetectOptions& options) override {
    return DeviceDetection(team_, {image, search, parts, options}, profile_).field();
  }

  void detect_async(const DetectRequest& request, const OnDetected& done) override {
    const auto detection = std::make_shared<DeviceDetection>(team_, request, profile_);
    detection->when_done([detection, done] { done(detection); });
  }

 private:
  static std::vector<std::unique_ptr<opencl::Device>> made_devices(const OpenclOptions& options) {
    std::vector<std::unique_ptr<opencl::Device>> devices;
    for (opencl::LocalDevice& device : opencl::chosen_devices(options.device)) {
      devices.push_back(std::make_unique<opencl::Device>(std::move(device), options));
    }
    return devices;
  }

  [[nodiscard]] std::vector<opencl::Worker*> workers() const {
    std::vector<opencl::Worker*> all;
    for (const auto& device : devices_) all.push_back(device.get());
    return all;
  }

  bool profile_;
  std::vector<std::unique_ptr<opencl::Device>> devices_;
  opencl::Team team_;
};

}  // namespace

bool OpenclOptions::is_valid(std::string* why) const {
  return require_positive(static_cast<double>(timeout.count()), "timeout in ms", why) &&
         require_at_least(group_size, 0, "group_size", why) && require_at_least(span_words, 0, "span_words", why) &&
         require_at_least(strip_rows, 0, "strip_rows", why);
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

std::string_view kernel_hash() {
  return opencl::kernel_hash();
}

std::unique_ptr<Backend> make_default_opencl_backend() {
  return make_opencl_backend();
}

}  // namespace cylpose
