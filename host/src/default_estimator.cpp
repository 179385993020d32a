#include <algorithm>
#include <cylpose/pose_solver.hpp>
#include <cylpose/search_region.hpp>
#include <utility>

#include "builtin_estimators.hpp"

namespace cylpose {
namespace {

class DefaultEstimator final : public Estimator {
 public:
  DefaultEstimator(const CameraModel& camera, const std::vector<PartModel>& parts, std::unique_ptr<Backend> backend)
      : solver_(camera, parts), region_(camera), backend_(std::move(backend)) {
    detect_options_.transfer = camera.transfer;
  }

  [[nodiscard]] std::string_view name() const override { return "default"; }

  [[nodiscard]] FrameEstimate estimate(const ImageView& image, StageTrace* trace) override {
    require_usable(image);
    require_calibrated_size(solver_.camera(), image);
    FrameEstimate result = estimate_in(image, region_.next(), trace);
    // A part that left the region carried over from the last frame, or lies across its border, is looked for
    // everywhere.
    if (region_.next() != region_.whole() && !all_found(result)) {
      FrameEstimate again = estimate_in(image, region_.whole(), trace);
      again.times.insert(again.times.begin(), result.times.begin(), result.times.end());
      result = std::move(again);
    }
    region_.update(solver_.parts(), result.parts);
    return result;
  }

  void reset() override { region_ = SearchRegion(solver_.camera()); }

 private:
  FrameEstimate estimate_in(const ImageView& image, const Roi& search, StageTrace* trace) {
    detect_options_.with_mask = trace != nullptr;
    EdgeField field = backend_->detect(image, search, solver_.parts(), detect_options_);
    FrameEstimate result;
    result.searched = field.searched;
    result.times = field.times;
    result.parts = solver_.solve(field, trace, &result.times);
    return result;
  }

  static bool all_found(const FrameEstimate& result) {
    return std::all_of(result.parts.begin(), result.parts.end(),
                       [](const PoseEstimate& part) { return part.status != PoseStatus::kNone; });
  }

  PoseSolver solver_;
  SearchRegion region_;
  std::unique_ptr<Backend> backend_;
  DetectOptions detect_options_;
};

}  // namespace

std::unique_ptr<Estimator> make_default_estimator(const CameraModel& camera, const std::vector<PartModel>& parts,
                                                  std::unique_ptr<Backend> backend) {
  return std::make_unique<DefaultEstimator>(camera, parts, std::move(backend));
}

}  // namespace cylpose
