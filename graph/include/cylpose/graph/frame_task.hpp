// What travels through the graph: one frame and all that becomes known about it on the way.
#pragma once

#include <chrono>
#include <cstdint>
#include <cylpose/edge_field.hpp>
#include <cylpose/error.hpp>
#include <cylpose/estimator.hpp>
#include <cylpose/image.hpp>
#include <cylpose/image_cv.hpp>
#include <cylpose/pose.hpp>
#include <functional>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <string>
#include <string_view>

namespace cylpose::graph {

using Clock = std::chrono::steady_clock;

/// Pixels, and whoever keeps them alive and unchanged for as long as a copy of `owner` exists. Never copied.
struct SharedImage {
  ImageView view;
  std::shared_ptr<const void> owner;
};

/// Shares the pixels of a cv::Mat (as view_of; throws the same). Nobody may write to them any more.
[[nodiscard]] inline SharedImage shared(cv::Mat image, PixelFormat color_order = PixelFormat::kBgr8) {
  const ImageView view = view_of(image, color_order);
  return {view, std::make_shared<const cv::Mat>(std::move(image))};
}

/// A frame as a source delivers it.
struct InputFrame {
  std::int64_t id = 0;  ///< the source's number; gaps are allowed
  double timestamp_s = 0;
  std::string name;  ///< for messages, such as the file; empty: the number says enough
  SharedImage image;
  std::optional<Error> failure;  ///< why there is no image
};

/// A frame in the graph. One node at a time has it; each fills in its part. A node to which a frame comes with a
/// failure does nothing and hands it on, so that every frame arrives and one bad frame never stops the stream.
struct FrameTask : InputFrame {
  std::uint64_t sequence = 0;   ///< 0, 1, 2, ... without gaps, in the order of entry: what OrderNode sorts by
  Clock::time_point entered;    ///< when the frame was handed over
  Roi search;                   ///< where to look; empty: everywhere
  bool searched_again = false;  ///< a part was not found in `search`, and `search` is empty now
  EdgeField field;              ///< from DetectNode
  FrameEstimate estimate;       ///< from SolveNode: one estimate per part, for failed frames `none` with the reason
  StageTrace stages;            ///< what the sequential stages saw; only on request
};

/// The message of all nodes.
using FramePtr = std::shared_ptr<FrameTask>;

/// A node at work on a frame.
struct NodeSpan {
  std::string_view node;  ///< a string literal
  const FrameTask& frame;
  Clock::time_point start;
  Clock::time_point end;
};

/// Told of every span where given, from the thread that did the work; must not throw. Without one no clock is read.
using NodeObserver = std::function<void(const NodeSpan& span)>;

}  // namespace cylpose::graph
