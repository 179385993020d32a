#include "contender.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cylpose/error.hpp>
#include <cylpose/opencl_devices.hpp>
#include <map>

#include "agreement.hpp"
#include "stage_counter.hpp"

namespace cylpose::bench {
namespace {

std::unique_ptr<Backend> profiling_backend(const std::string& name) {
  if (name != "opencl") return nullptr;
  OpenclOptions options;
  options.profile = true;
  return make_opencl_backend(options);
}

void add(const std::vector<StageTime>& times, std::vector<StageTime>& sums) {
  for (const StageTime& time : times) {
    const auto known = std::ranges::find(sums, time.stage, &StageTime::stage);
    if (known == sums.end()) {
      sums.push_back(time);
    } else {
      known->milliseconds += time.milliseconds;
    }
  }
}

void require(bool good, const std::string& backend, const std::string& scene, const std::string& what) {
  if (!good) throw Error(ErrorKind::kDevice, fmt::format("{} on {}: {}", backend, scene, what));
}

}  // namespace

DetectOptions detect_options(const BenchScene& scene) {
  DetectOptions options;
  options.transfer = scene.camera.transfer;
  return options;
}

Contender& Contender::named(const std::string& name) {
  static std::map<std::string, std::unique_ptr<Contender>> contenders;
  std::unique_ptr<Contender>& contender = contenders[name];
  if (contender == nullptr) contender.reset(new Contender(name));
  return *contender;
}

Contender::Contender(const std::string& name)
    : name_(name), backend_(make_backend(name)), profiling_(profiling_backend(name)) {
  require(backend_->name() == name, name, "any scene", "it is '" + std::string(backend_->name()) + "' that was made");
}

void Contender::require_agreement(const BenchScene& scene, const std::string& scene_name) {
  if (agreed_.contains(scene_name)) return;
  const std::unique_ptr<Backend> serial = make_backend("serial");
  const PoseSolver solver(scene.camera, scene.parts);
  const Tolerance tolerance = tolerance_of(name_);
  DetectOptions options = detect_options(scene);
  for (const bool with_mask : {true, false}) {
    options.with_mask = with_mask;
    const EdgeField expected = serial->detect(scene.image(), scene.search, scene.parts, options);
    const EdgeField actual = backend_->detect(scene.image(), scene.search, scene.parts, options);
    const std::vector<PoseEstimate> expected_poses = solver.solve(expected);
    require(std::ranges::all_of(expected_poses, [](const auto& pose) { return pose.status == PoseStatus::kOk; }),
            "serial", scene_name, "a part was not found, so there is nothing to compare");
    std::string wrong = difference(expected, actual, tolerance);
    if (wrong.empty()) wrong = difference(expected_poses, solver.solve(actual), tolerance);
    require(wrong.empty(), name_, scene_name, "not the answer of serial: " + wrong);
  }
  agreed_.insert(scene_name);
}

void Contender::count_stages(const BenchScene& scene, const PoseSolver* solver, benchmark::State& state) {
  constexpr int kFewestFrames = 3;
  constexpr std::chrono::milliseconds kLongest(20);
  Backend& backend = profiling_ != nullptr ? *profiling_ : *backend_;
  const DetectOptions options = detect_options(scene);
  // The first frame through the profiling backend builds its programs and buffers.
  if (profiling_ != nullptr) static_cast<void>(backend.detect(scene.image(), scene.search, scene.parts, options));

  std::vector<StageTime> sums;
  int frames = 0;
  const auto start = std::chrono::steady_clock::now();
  while (frames < kFewestFrames || std::chrono::steady_clock::now() - start < kLongest) {
    const EdgeField field = backend.detect(scene.image(), scene.search, scene.parts, options);
    std::vector<StageTime> times = field.times;
    if (solver != nullptr) static_cast<void>(solver->solve(field, nullptr, &times));
    add(times, sums);
    ++frames;
  }
  for (std::size_t i = 0; i < sums.size(); ++i) {
    state.counters[stage_counter(i, sums[i].stage)] = sums[i].milliseconds / frames;
  }
}

}  // namespace cylpose::bench
