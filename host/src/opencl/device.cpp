#include "opencl/device.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <utility>

#include "linear_light.hpp"
#include "opencl/strip_run.hpp"

namespace cylpose::opencl {
namespace {

Context context_for(const LocalDevice& device) {
  const std::array<cl_context_properties, 3> properties{CL_CONTEXT_PLATFORM,
                                                        reinterpret_cast<cl_context_properties>(device.platform), 0};
  cl_int code = CL_SUCCESS;
  Context context(clCreateContext(properties.data(), 1, &device.id, nullptr, nullptr, &code));
  check(code, "clCreateContext", display_name(device.info));
  return context;
}

std::string identity_of(const LocalDevice& device) {
  const OpenclDevice& info = device.info;
  return info.platform + "\n" + device.platform_version + "\n" + info.name + "\n" + info.device_version + "\n" +
         info.driver_version;
}

Memory light_tables_in(cl_context context, std::string_view name) {
  std::vector<std::uint16_t> tables;
  for (const Transfer transfer : {Transfer::kSrgb, Transfer::kLinear}) {
    const LinearTable& table = linear_light(transfer);
    tables.insert(tables.end(), table.begin(), table.end());
  }
  cl_int code = CL_SUCCESS;
  Memory memory(clCreateBuffer(context, CL_MEM_READ_ONLY | CL_MEM_COPY_HOST_PTR, tables.size() * sizeof tables[0],
                               tables.data(), &code));
  check(code, "clCreateBuffer", name);
  return memory;
}

std::optional<ProgramCache> cache_for(const OpenclOptions& options) {
  if (!options.cache_programs) return std::nullopt;
  std::filesystem::path folder = options.cache_dir.empty() ? default_cache_folder() : options.cache_dir;
  if (folder.empty()) return std::nullopt;
  return ProgramCache(std::move(folder));
}

// A driver may say that memory is shared and copy all the same (devices behind a network do), so it is timed: the first
// access to host memory in place against a copy into the device's.
bool in_place_is_quicker(cl_context context, cl_device_id device, std::string_view name) {
  using Clock = std::chrono::steady_clock;
  constexpr std::size_t kBytes = 4 << 20;
  constexpr int kTries = 3;
  std::vector<unsigned char> host(kBytes, 1);
  std::array<unsigned char, 64> few{};
  cl_int code = CL_SUCCESS;
  const Queue queue(clCreateCommandQueue(context, device, 0, &code));
  check(code, "clCreateCommandQueue", name);
  const Memory own(clCreateBuffer(context, CL_MEM_READ_ONLY, kBytes, nullptr, &code));
  check(code, "clCreateBuffer", name);

  const auto read_few = [&](cl_mem memory) {
    check(clEnqueueReadBuffer(queue.get(), memory, CL_TRUE, 0, few.size(), few.data(), 0, nullptr, nullptr),
          "clEnqueueReadBuffer", name);
  };
  auto in_place = Clock::duration::max();
  auto copied = Clock::duration::max();
  for (int i = 0; i < kTries; ++i) {
    const auto start = Clock::now();
    {
      const Memory shared(clCreateBuffer(context, CL_MEM_READ_ONLY | CL_MEM_USE_HOST_PTR, kBytes, host.data(), &code));
      check(code, "clCreateBuffer", name);
      read_few(shared.get());
    }
    const auto middle = Clock::now();
    check(clEnqueueWriteBuffer(queue.get(), own.get(), CL_FALSE, 0, kBytes, host.data(), 0, nullptr, nullptr),
          "clEnqueueWriteBuffer", name);
    read_few(own.get());
    in_place = std::min(in_place, middle - start);
    copied = std::min(copied, Clock::now() - middle);
  }
  return in_place < copied;
}

}  // namespace

LaunchShape::LaunchShape(const OpenclDevice& device, const OpenclOptions& options)
    : cpu_(device.type == "cpu"), cores_(static_cast<std::size_t>(std::max(device.compute_units, 1))) {
  constexpr int kLongestRow = 512;  // words of 32767 pixels
  constexpr int kUsualGroup = 64;   // a multiple of what GPUs run in lockstep
  group_size_ = static_cast<std::size_t>(options.group_size != 0 ? options.group_size : cpu_ ? 1 : kUsualGroup);
  span_words_ = options.span_words != 0 ? options.span_words : cpu_ ? kLongestRow : 1;
}

std::size_t LaunchShape::items(std::size_t units, std::size_t shares) const {
  const std::size_t wanted = std::max<std::size_t>(cpu_ ? std::min(units, cores_ * shares) : units, 1);
  return (wanted + group_size_ - 1) / group_size_ * group_size_;
}

Device::Device(LocalDevice device, const OpenclOptions& options)
    : part_(std::move(device.part)),
      info_(device.info),
      shape_(device.info, options),
      profile_(options.profile),
      timeout_(options.timeout),
      cache_(cache_for(options)),
      context_(context_for(device)),
      target_{context_.get(), device.id, display_name(device.info), identity_of(device)},
      light_tables_(light_tables_in(context_.get(), target_.device_name)),
      zero_copy_(!options.copy_frames && info_.shares_memory &&
                 in_place_is_quicker(context_.get(), device.id, target_.device_name)) {}

Device::~Device() = default;

cl_program Device::program(PixelFormat format) {
  const std::scoped_lock lock(program_mutex_);
  const auto found = programs_.find(format);
  if (found != programs_.end()) return found->second.get();
  const KernelParameters parameters{format, static_cast<int>(shape_.group_size()), shape_.span_words()};
  Program program = built_kernels(target_, parameters, cache_ ? &*cache_ : nullptr);
  return programs_.emplace(format, std::move(program)).first->second.get();
}

std::unique_ptr<StripJob> Device::take_job() {
  {
    const std::scoped_lock lock(job_mutex_);
    if (!idle_jobs_.empty()) {
      std::unique_ptr<StripJob> job = std::move(idle_jobs_.back());
      idle_jobs_.pop_back();
      return job;
    }
  }
  return std::make_unique<StripRun>(*this);
}

void Device::give_back(std::unique_ptr<StripJob> job) {
  const std::scoped_lock lock(job_mutex_);
  idle_jobs_.push_back(std::move(job));
}

}  // namespace cylpose::opencl
