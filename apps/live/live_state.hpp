// What a run shows while it goes on: the latest frame, counts, messages. The pipeline writes, viewers read.
#pragma once

#include <array>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <cylpose/camera.hpp>
#include <cylpose/extrinsics.hpp>
#include <cylpose/graph/pipeline.hpp>
#include <cylpose/part.hpp>
#include <cylpose/pose_io.hpp>
#include <cylpose/report.hpp>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace cylpose::apps {

/// The nodes of the cluster and what became of tiles, as cluster::ClusterBackend counts them; plain, since a build
/// without the cluster shows the page, too.
struct ClusterView {
  struct Node {
    std::string name;
    int slots = 0;
    double pixels_per_ms = 0;
    std::int64_t used = 0;
    std::int64_t failed = 0;
  };
  std::vector<Node> nodes;
  std::int64_t sent = 0, used = 0, late = 0, refused = 0, taken_back = 0;
};
using AskCluster = std::function<ClusterView()>;

struct LivePart {
  PoseRow latest;                            ///< of the latest frame, as the poses file has it
  std::array<std::uint64_t, 3> by_status{};  ///< frames so far, by PoseStatus
};

struct LiveMessage {
  std::string text;
  std::uint64_t times = 1;
};

/// All that viewers see but the picture, of one moment.
struct LiveView {
  bool ended = false;
  double seconds = 0;  ///< since the run began; stands still at its end
  graph::PipelineStatistics pipeline;
  std::int64_t frame = -1;  ///< the latest; below 0: none yet
  double timestamp_s = 0;
  std::string failure;          ///< of the latest frame: why there is no image
  double latency_ms = 0;        ///< of the latest frame, from put to the call of the sink
  std::int64_t picture = -1;    ///< the latest frame with an image; below 0: none yet
  std::vector<LivePart> parts;  ///< in the order of the part models
  std::optional<ClusterView> cluster;
  std::vector<LiveMessage> messages;  ///< the latest kMostMessages, the newest last
  std::uint64_t messages_in_all = 0;
};

class LiveState {
 public:
  /// `facts`: what the run is about. With `extrinsics` poses are shown in the body's frame.
  LiveState(CameraModel camera, std::vector<PartModel> parts, std::optional<Extrinsics> extrinsics,
            std::vector<ReportFact> facts);

  /// While it lives, the run goes on.
  class Attachment {
   public:
    explicit Attachment(LiveState* state) : state_(state) {}
    Attachment(Attachment&& other) noexcept : state_(std::exchange(other.state_, nullptr)) {}
    Attachment& operator=(Attachment&&) = delete;
    ~Attachment();

   private:
    LiveState* state_;
  };
  /// `pipeline` and `cluster` (which may be empty) are asked for as long as the attachment lives.
  [[nodiscard]] Attachment attach(const graph::Pipeline& pipeline, AskCluster cluster);

  /// A frame at the sink, calls one at a time. Never waits: while a viewer just takes the frame before, this one is
  /// not shown.
  void offer(const graph::FramePtr& frame);

  /// All frames have been offered: shows the last one, if it is not shown yet.
  void settle();

  /// Something the user should know. Any thread.
  void tell(const std::string& text);

  [[nodiscard]] const CameraModel& camera() const { return camera_; }
  [[nodiscard]] const std::vector<PartModel>& parts() const { return parts_; }
  [[nodiscard]] const std::vector<ReportFact>& facts() const { return facts_; }

  /// Any thread. The pipeline is asked again at most every kViewAge, however many viewers there are.
  [[nodiscard]] std::shared_ptr<const LiveView> view() const;

  /// The latest frame that has an image; null when there is none yet.
  [[nodiscard]] graph::FramePtr frame_with_image() const;

  [[nodiscard]] bool has_ended() const { return has_ended_; }
  /// Waits until the run has ended, or so long.
  void wait_for_end(std::chrono::milliseconds patience) const;

  static constexpr std::size_t kMostMessages = 20;
  static constexpr std::chrono::milliseconds kViewAge{100};

 private:
  using Clock = std::chrono::steady_clock;

  struct Slot {
    graph::FramePtr latest;
    graph::FramePtr with_image;
    double latency_ms = 0;
  };

  void end();
  [[nodiscard]] LiveView made_view() const;
  [[nodiscard]] Slot slot() const;

  const CameraModel camera_;
  const std::vector<PartModel> parts_;
  const std::optional<Extrinsics> extrinsics_;
  const std::vector<ReportFact> facts_;
  const Clock::time_point start_ = Clock::now();

  Slot newest_;  ///< of the sink alone
  std::vector<std::array<std::atomic<std::uint64_t>, 3>> by_status_;
  mutable std::mutex slot_mutex_;
  Slot slot_;

  mutable std::mutex messages_mutex_;
  std::vector<LiveMessage> messages_;
  std::uint64_t messages_in_all_ = 0;

  mutable std::mutex view_mutex_;  ///< the pipeline's threads never take it
  mutable std::condition_variable ended_;
  const graph::Pipeline* pipeline_ = nullptr;
  AskCluster cluster_;
  std::atomic<bool> has_ended_ = false;
  mutable std::shared_ptr<const LiveView> view_;
  mutable Clock::time_point view_made_;
};

}  // namespace cylpose::apps
