// A backend under test, with the question whether it is right, and where its time goes.
#pragma once

#include <benchmark/benchmark.h>

#include <cylpose/backend.hpp>
#include <cylpose/pose_solver.hpp>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "scenes.hpp"

namespace cylpose::bench {

class Contender {
 public:
  /// The one of this name, made at the first call. Throws Error where the backend cannot be made.
  static Contender& named(const std::string& name);

  [[nodiscard]] Backend& backend() { return *backend_; }

  /// Throws Error(kDevice) unless the backend gives the answer of `serial`, poses included, and there is something to
  /// find. Compares once per `scene_name`.
  void require_agreement(const BenchScene& scene, const std::string& scene_name);

  /// Mean wall or device time of the stages over some frames, as counters (stage_counter.hpp). With `solver`, its
  /// stages too. Apart from the timing, because asking for device times slows the backend down.
  void count_stages(const BenchScene& scene, const PoseSolver* solver, benchmark::State& state);

 private:
  explicit Contender(const std::string& name);

  std::string name_;
  std::unique_ptr<Backend> backend_;
  std::unique_ptr<Backend> profiling_;  ///< where a backend tells more when asked to
  std::set<std::string> agreed_;
};

[[nodiscard]] DetectOptions detect_options(const BenchScene& scene);

}  // namespace cylpose::bench
