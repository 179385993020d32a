// Where to look in a frame while the frames just before it are still being worked on.
#pragma once

#include <cylpose/camera.hpp>
#include <cylpose/graph/frame_task.hpp>
#include <cylpose/part.hpp>
#include <cylpose/pose_filter.hpp>
#include <cylpose/search_region.hpp>
#include <optional>
#include <vector>

namespace cylpose::graph {

/// Keeps what was known after each of the last `lag` frames, so that the region of frame k is a function of the results
/// up to frame k - lag, of all of them and of no later one, however quickly those came. With lag 1 that is what an
/// Estimator does.
class SearchPlan {
 public:
  SearchPlan(const CameraModel& camera, std::vector<PartModel> parts, int lag, std::optional<PoseFilter> filter);

  /// The region of a frame; whole for the first `lag` frames. Frame `sequence - lag` must have been taken in. May run
  /// beside take_in of later frames.
  [[nodiscard]] Roi region(const FrameTask& frame) const;

  /// Takes in the estimates of the next frame in order and, with a filter, puts the filtered ones in their place; a
  /// frame that the filter refuses (its time stamp does not increase) becomes a failed one. A failed frame says nothing
  /// about the parts: without a filter the region stays, with one it follows the prediction.
  void take_in(FrameTask& frame);

 private:
  struct Known {
    Roi next;
    std::optional<PoseFilter> filter;
  };

  [[nodiscard]] std::size_t place(std::uint64_t sequence) const { return sequence % known_.size(); }
  void apply_filter(FrameTask& frame);

  std::vector<PartModel> parts_;
  SearchRegion region_;
  std::optional<PoseFilter> filter_;
  std::vector<Known> known_;  ///< after frame s at s % lag
};

}  // namespace cylpose::graph
