// The nodes by themselves, in graphs of the user's own.
#include <gmock/gmock.h>

#include <cylpose/graph/nodes.hpp>
#include <opencv2/core.hpp>
#include <sstream>

#include "../host/temp_dir.hpp"
#include "stream.hpp"

namespace cylpose::graph {
namespace {

using testing::expect_same;
using testing::make_slow_device;
using testing::one_at_a_time;
using testing::stream_camera;
using testing::stream_frame;
using testing::stream_parts;

std::shared_ptr<const PoseSolver> solver() {
  return std::make_shared<const PoseSolver>(stream_camera(), stream_parts());
}

TEST(Nodes, MakeAGraphOfTheUsersOwnWithAnyConcurrencyBetween) {
  constexpr int kFrames = testing::kStreamFrames;
  const auto device = make_slow_device(1, 2000);
  tbb::flow::graph graph;
  PushNode push(graph);
  tbb::flow::limiter_node<FramePtr> limiter(graph, 4);
  DetectNode detect(graph, *device, stream_parts());
  SolveNode solve(graph, solver(), tbb::flow::unlimited);
  OrderNode order(graph);
  std::vector<FramePtr> results;
  SinkNode sink(graph, [&](const FramePtr& frame) { results.push_back(frame); });
  tbb::flow::queue_node<FramePtr> queue(graph);
  make_edge(push, queue);
  make_edge(queue, limiter);
  make_edge(limiter, detect);
  make_edge(detect, solve);
  make_edge(solve, order);
  make_edge(order, sink);
  make_edge(sink, limiter.decrementer());
  for (int i = 0; i < kFrames; ++i) {
    auto task = std::make_shared<FrameTask>();
    static_cast<InputFrame&>(*task) = testing::good_frame(i);
    push.try_put(task);
  }
  graph.wait_for_all();
  ASSERT_EQ(results.size(), static_cast<std::size_t>(kFrames));
  for (int i = 0; i < kFrames; ++i) {
    const FramePtr& frame = results[static_cast<std::size_t>(i)];
    EXPECT_EQ(frame->id, i);
    // Every frame is searched as a whole where nobody says otherwise: each is a stream's first.
    expect_same(frame->estimate, one_at_a_time({testing::good_frame(i)}, 1)[0], "frame " + std::to_string(i));
  }
}

TEST(Nodes, RetrySendsBackWhatWasNotFoundInItsRegion) {
  const auto serial = make_backend("serial");
  tbb::flow::graph graph;
  DetectNode detect(graph, *serial, stream_parts());
  SolveNode solve(graph, solver(), 1);
  RetryNode retry(graph);
  std::vector<FramePtr> results;
  SinkNode sink(graph, [&](const FramePtr& frame) { results.push_back(frame); });
  make_edge(detect, solve);
  make_edge(solve, retry);
  make_edge(tbb::flow::output_port<0>(retry), sink);
  make_edge(tbb::flow::output_port<1>(retry), detect);
  for (const Roi search : {Roi{0, 0, 20, 20}, Roi{}}) {
    auto task = std::make_shared<FrameTask>();
    static_cast<InputFrame&>(*task) = testing::good_frame(0);
    task->search = search;
    detect.try_put(task);
    graph.wait_for_all();
    EXPECT_EQ(results.back()->searched_again, !search.empty());
    EXPECT_EQ(results.back()->estimate.parts[0].status, PoseStatus::kOk);
  }
  // Nothing to be found anywhere: once again, not for ever.
  auto hidden = std::make_shared<FrameTask>();
  static_cast<InputFrame&>(*hidden) = testing::good_frame(14);
  hidden->search = {50, 50, 40, 40};
  detect.try_put(hidden);
  graph.wait_for_all();
  ASSERT_EQ(results.size(), 3U);
  EXPECT_EQ(results.back()->estimate.parts[0].status, PoseStatus::kNone);
}

class ThreeFrames final : public FrameSource {
 public:
  std::optional<Frame> next() override {
    if (next_ == 3) return std::nullopt;
    Frame frame;
    frame.index = next_++;
    frame.timestamp_s = 0.1 * static_cast<double>(frame.index);
    frame.name = "picture " + std::to_string(frame.index);
    if (frame.index == 1) {
      frame.error = "picture 1: is no image";
    } else {
      frame.image = mat_of(testing::good_frame(0).image.view).clone();
    }
    return frame;
  }
  [[nodiscard]] std::optional<std::int64_t> size() const override { return 3; }
  [[nodiscard]] double fps() const override { return 10; }
  [[nodiscard]] std::vector<std::string> warnings() const override { return {}; }

 private:
  std::int64_t next_ = 0;
};

TEST(Nodes, ASourceEndsInFilesAndPictures) {
  const TempDir folder;
  const std::filesystem::path file = folder.path() / "poses.csv";
  const auto writer = std::make_shared<PoseWriter>(file, PoseFormat::kCsv, std::vector<std::string>{"can"});
  tbb::flow::graph graph;
  SourceNode source(graph, std::make_unique<ThreeFrames>());
  const auto serial = make_backend("serial");
  DetectNode detect(graph, *serial, stream_parts());
  SolveNode solve(graph, solver(), tbb::flow::unlimited);
  OrderNode order(graph);
  OrderNode order_of_pictures(graph);
  tbb::flow::function_node<FramePtr, FramePtr> name(graph, tbb::flow::serial, [](const FramePtr& frame) {
    frame->name += " seen";  // a node of the user's own
    return frame;
  });
  SinkNode poses(graph, write_poses(writer));
  std::vector<std::string> drawn;
  SinkNode pictures(graph,
                    draw_overlays(stream_camera(), stream_parts(), [&](const FramePtr& frame, const cv::Mat& picture) {
                      EXPECT_EQ(picture.size(), cv::Size(200, 150));
                      EXPECT_GT(cv::norm(picture, mat_of(frame->image.view)), 0) << "nothing is drawn";
                      drawn.push_back(frame->name);
                    }));
  make_edge(source, detect);
  make_edge(detect, solve);
  make_edge(solve, name);
  make_edge(name, order);
  make_edge(name, order_of_pictures);
  make_edge(order, poses);
  make_edge(order_of_pictures, pictures);
  source.activate();
  graph.wait_for_all();
  writer->close();
  EXPECT_EQ(drawn, (std::vector<std::string>{"picture 0 seen", "picture 2 seen"}));
  const std::vector<PoseRow> rows = load_poses(file);
  ASSERT_EQ(rows.size(), 3U);
  EXPECT_EQ(rows[0].status, PoseStatus::kOk);
  EXPECT_EQ(rows[1].status, PoseStatus::kNone);
  EXPECT_EQ(rows[2].frame, 2);
}

TEST(Nodes, WhatASinkThrowsComesOutOfTheGraphsWait) {
  tbb::flow::graph graph;
  SinkNode sink(graph, [](const FramePtr&) { throw Error(ErrorKind::kOutput, "full"); });
  sink.try_put(std::make_shared<FrameTask>());
  EXPECT_THROW(graph.wait_for_all(), Error);
}

TEST(Nodes, ObserversSeeEveryVisit) {
  const auto serial = make_backend("serial");
  std::mutex mutex;
  std::vector<std::string> spans;
  const NodeObserver observer = [&](const NodeSpan& span) {
    const std::scoped_lock lock(mutex);
    EXPECT_LE(span.start, span.end);
    EXPECT_EQ(span.frame.id, 3);
    spans.emplace_back(span.node);
  };
  tbb::flow::graph graph;
  DetectNode detect(graph, *serial, stream_parts(), {}, observer);
  SolveNode solve(graph, solver(), 1, false, observer);
  SinkNode sink(
      graph, [](const FramePtr&) {}, observer);
  make_edge(detect, solve);
  make_edge(solve, sink);
  auto task = std::make_shared<FrameTask>();
  static_cast<InputFrame&>(*task) = stream_frame(3);
  detect.try_put(task);
  graph.wait_for_all();
  EXPECT_THAT(spans, ::testing::UnorderedElementsAre("detect", "device", "collect", "solve", "sink"));
}

}  // namespace
}  // namespace cylpose::graph
