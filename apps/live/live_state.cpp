#include "live_state.hpp"

#include <algorithm>
#include <utility>

namespace cylpose::apps {

LiveState::LiveState(CameraModel camera, std::vector<PartModel> parts, std::optional<Extrinsics> extrinsics,
                     std::vector<ReportFact> facts)
    : camera_(std::move(camera)),
      parts_(std::move(parts)),
      extrinsics_(std::move(extrinsics)),
      facts_(std::move(facts)),
      by_status_(parts_.size()) {}

LiveState::Attachment::~Attachment() {
  if (state_ != nullptr) state_->end();
}

LiveState::Attachment LiveState::attach(const graph::Pipeline& pipeline, AskCluster cluster) {
  const std::scoped_lock lock(view_mutex_);
  pipeline_ = &pipeline;
  cluster_ = std::move(cluster);
  return Attachment(this);
}

void LiveState::offer(const graph::FramePtr& frame) {
  for (std::size_t i = 0; i < by_status_.size(); ++i) {
    const auto status = static_cast<std::size_t>(frame->estimate.parts[i].status);
    by_status_[i][status].fetch_add(1, std::memory_order_relaxed);
  }
  newest_.latest = frame;
  newest_.latency_ms = std::chrono::duration<double, std::milli>(graph::Clock::now() - frame->entered).count();
  if (!frame->failure) newest_.with_image = frame;
  Slot shown;  // destroyed after the lock: frees pixels
  const std::unique_lock lock(slot_mutex_, std::try_to_lock);
  if (lock) shown = std::exchange(slot_, newest_);
}

void LiveState::settle() {
  const std::scoped_lock lock(slot_mutex_);
  slot_ = newest_;
}

void LiveState::tell(const std::string& text) {
  const std::scoped_lock lock(messages_mutex_);
  ++messages_in_all_;
  const auto known = std::ranges::find(messages_, text, &LiveMessage::text);
  LiveMessage message{text, 1};
  if (known != messages_.end()) {
    message.times += known->times;
    messages_.erase(known);
  } else if (messages_.size() == kMostMessages) {
    messages_.erase(messages_.begin());
  }
  messages_.push_back(std::move(message));
}

std::shared_ptr<const LiveView> LiveState::view() const {
  const std::scoped_lock lock(view_mutex_);
  const Clock::time_point now = Clock::now();
  if (!view_ || (!has_ended_ && now - view_made_ >= kViewAge)) {
    view_ = std::make_shared<const LiveView>(made_view());
    view_made_ = now;
  }
  return view_;
}

graph::FramePtr LiveState::frame_with_image() const {
  return slot().with_image;
}

void LiveState::wait_for_end(std::chrono::milliseconds patience) const {
  std::unique_lock lock(view_mutex_);
  ended_.wait_for(lock, patience, [this] { return has_ended_.load(); });
}

void LiveState::end() {
  const std::scoped_lock lock(view_mutex_);
  has_ended_ = true;
  view_ = std::make_shared<const LiveView>(made_view());
  pipeline_ = nullptr;
  cluster_ = nullptr;
  ended_.notify_all();
}

LiveState::Slot LiveState::slot() const {
  const std::scoped_lock lock(slot_mutex_);
  return slot_;
}

// Requires the view's lock.
LiveView LiveState::made_view() const {
  LiveView view;
  view.ended = has_ended_;
  view.seconds = std::chrono::duration<double>(Clock::now() - start_).count();
  if (pipeline_ != nullptr) view.pipeline = pipeline_->statistics();
  if (cluster_) view.cluster = cluster_();
  const Slot shown = slot();
  view.parts.resize(parts_.size());
  for (std::size_t i = 0; i < parts_.size(); ++i) {
    LivePart& part = view.parts[i];
    part.latest.part = parts_[i].name;
    for (std::size_t status = 0; status < part.by_status.size(); ++status) {
      part.by_status[status] = by_status_[i][status].load(std::memory_order_relaxed);
    }
  }
  if (shown.latest) {
    const graph::FrameTask& frame = *shown.latest;
    view.frame = frame.id;
    view.timestamp_s = frame.timestamp_s;
    view.latency_ms = shown.latency_ms;
    if (frame.failure) view.failure = frame.failure->what();
    const FrameEstimate estimate = extrinsics_ ? in_body(frame.estimate, *extrinsics_) : frame.estimate;
    for (std::size_t i = 0; i < parts_.size(); ++i) {
      view.parts[i].latest = pose_row(frame.id, frame.timestamp_s, parts_[i].name, estimate.parts[i]);
    }
  }
  if (shown.with_image) view.picture = shown.with_image->id;
  const std::scoped_lock lock(messages_mutex_);
  view.messages = messages_;
  view.messages_in_all = messages_in_all_;
  return view;
}

}  // namespace cylpose::apps
