#include "search_plan.hpp"

#include <utility>

#include "failure.hpp"

namespace cylpose::graph {

SearchPlan::SearchPlan(const CameraModel& camera, std::vector<PartModel> parts, int lag,
                       std::optional<PoseFilter> filter)
    : parts_(std::move(parts)),
      region_(camera),
      filter_(std::move(filter)),
      known_(static_cast<std::size_t>(lag), Known{region_.whole(), filter_}) {}

Roi SearchPlan::region(const FrameTask& frame) const {
  const Known& known = known_[place(frame.sequence)];  // that of frame sequence - lag
  if (!known.filter) return known.next;
  try {
    return known.filter->search_region(frame.timestamp_s);
  } catch (const Error&) {  // a time stamp that take_in will refuse
    return region_.whole();
  }
}

void SearchPlan::take_in(FrameTask& frame) {
  if (filter_) {
    apply_filter(frame);
  } else if (!frame.failure) {
    region_.update(parts_, frame.estimate.parts);
  }
  Known& known = known_[place(frame.sequence)];
  known.next = region_.next();
  known.filter = filter_;
}

void SearchPlan::apply_filter(FrameTask& frame) {
  try {
    frame.estimate.parts = filter_->update(frame.timestamp_s, frame.estimate.parts);
  } catch (...) {
    frame.failure = current_failure();
    frame.estimate.parts = no_poses(frame, parts_.size());
  }
}

}  // namespace cylpose::graph
