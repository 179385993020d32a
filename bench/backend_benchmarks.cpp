// From a frame in memory to its edges, and to poses, by every backend.
#include <fmt/format.h>

#include <array>
#include <cylpose/search_region.hpp>
#include <exception>
#include <string>
#include <utility>

#include "benchmarks.hpp"
#include "contender.hpp"

namespace cylpose::bench {
namespace {

using SceneOfSize = BenchScene (*)(const FrameSize& size);
constexpr std::array<std::pair<const char*, SceneOfSize>, 2> kScenes{{{"full", full_scene}, {"roi", roi_scene}}};

template <typename Run>
void add_guarded(const Register& add, const std::string& name, Run run) {
  benchmark::internal::Benchmark* added = add(name, [run = std::move(run)](benchmark::State& state) {
    try {
      run(state);
    } catch (const std::exception& error) {
      // An error of this benchmark; the others go on.
      state.SkipWithError(error.what());
    }
  });
  if (added != nullptr) added->UseRealTime();
}

void count_frames(const BenchScene& scene, benchmark::State& state) {
  const double pixels = static_cast<double>(scene.search.width) * scene.search.height;
  const double bytes = pixels * bytes_per_pixel(scene.image().format);
  constexpr auto kRate = benchmark::Counter::kIsIterationInvariantRate;
  state.counters["frames/s"] = benchmark::Counter(1, kRate);
  state.counters["Mpixel/s"] = benchmark::Counter(pixels * 1e-6, kRate);
  state.counters["GB/s"] = benchmark::Counter(bytes * 1e-9, kRate);
  state.counters["frame_bytes"] = bytes;
}

void detect(const std::string& backend, const BenchScene& scene, benchmark::State& state) {
  Contender& contender = Contender::named(backend);
  const DetectOptions options = detect_options(scene);
  for (auto _ : state) {
    EdgeField field = contender.backend().detect(scene.image(), scene.search, scene.parts, options);
    benchmark::DoNotOptimize(field.parts.data());
  }
}

// What Estimator::estimate does with a frame; the search region stays, so that all frames are alike.
void estimate(const std::string& backend, const BenchScene& scene, const PoseSolver& solver, benchmark::State& state) {
  Contender& contender = Contender::named(backend);
  const DetectOptions options = detect_options(scene);
  SearchRegion region(scene.camera);
  for (auto _ : state) {
    const EdgeField field = contender.backend().detect(scene.image(), scene.search, scene.parts, options);
    const std::vector<PoseEstimate> poses = solver.solve(field);
    region.update(scene.parts, poses);
    benchmark::DoNotOptimize(region);
  }
}

void register_scenes(const std::string& backend, const Register& add) {
  for (const auto& [scene_name, scene_of] : kScenes) {
    for (const FrameSize& size : kFrameSizes) {
      const std::string name = fmt::format("{}/{}", scene_name, to_string(size));
      add_guarded(add, fmt::format("detect/{}/{}", backend, name), [=, scene_of = scene_of](benchmark::State& state) {
        const BenchScene scene = scene_of(size);
        Contender::named(backend).require_agreement(scene, name);
        detect(backend, scene, state);
        count_frames(scene, state);
        Contender::named(backend).count_stages(scene, nullptr, state);
      });
      add_guarded(add, fmt::format("estimate/{}/{}", backend, name), [=, scene_of = scene_of](benchmark::State& state) {
        const BenchScene scene = scene_of(size);
        Contender::named(backend).require_agreement(scene, name);
        const PoseSolver solver(scene.camera, scene.parts);
        estimate(backend, scene, solver, state);
        count_frames(scene, state);
        Contender::named(backend).count_stages(scene, &solver, state);
      });
    }
  }
}

}  // namespace

void register_backend_benchmarks(const Register& add) {
  for (const BackendInfo& backend : backends()) {
    register_scenes(backend.name, add);
    add_guarded(add, "overhead/" + backend.name,
                [name = backend.name](benchmark::State& state) { detect(name, empty_scene(), state); });
  }
}

}  // namespace cylpose::bench
