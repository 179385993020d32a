// What viewers get, and that the pipeline never waits for them.
#include "live/live_state.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "browser.hpp"
#include "graph/stream.hpp"
#include "live/live_page.hpp"
#include "live/live_text.hpp"

namespace cylpose::apps {
namespace {

using cylpose::testing::Connection;
using cylpose::testing::get;
using cylpose::testing::good_frame;
using cylpose::testing::kStreamFrames;
using cylpose::testing::stream_camera;
using cylpose::testing::stream_parts;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

std::unique_ptr<LiveState> stream_state(std::vector<ReportFact> facts = {}) {
  return std::make_unique<LiveState>(stream_camera(), stream_parts(), std::nullopt, std::move(facts));
}

// A stream through a pipeline whose sink shows it.
struct Watched {
  explicit Watched(LiveState* live)
      : pipeline(stream_camera(), stream_parts(), make_backend("serial"),
                 [live](const graph::FramePtr& frame) { live->offer(frame); }),
        attached(live->attach(pipeline, {})) {}

  void run(int frames) {
    for (int i = 0; i < frames; ++i) {
      graph::InputFrame frame = good_frame(i % 3);  // in which the part is found
      frame.id = i;
      pipeline.put(std::move(frame));
    }
    pipeline.wait_for_all();
  }

  graph::Pipeline pipeline;
  LiveState::Attachment attached;
};

TEST(LiveState, CountsEveryFrameAndShowsTheLatest) {
  const auto live = stream_state();
  EXPECT_EQ(live->view()->frame, -1);
  EXPECT_EQ(live->frame_with_image(), nullptr);
  {
    Watched watched(live.get());
    for (int i = 0; i < kStreamFrames; ++i) watched.pipeline.put(cylpose::testing::stream_frame(i));
    graph::InputFrame unreadable;
    unreadable.id = 99;
    unreadable.failure = Error(ErrorKind::kInput, "torn.png: cannot be read");
    watched.pipeline.put(unreadable);
    watched.pipeline.wait_for_all();
    live->settle();
  }
  const auto view = live->view();
  EXPECT_TRUE(view->ended);
  EXPECT_EQ(view->frame, 99);
  EXPECT_THAT(view->failure, HasSubstr("torn.png"));
  EXPECT_NE(view->picture, 99) << "there is no picture of it";
  EXPECT_EQ(live->frame_with_image()->id, view->picture);
  EXPECT_EQ(view->pipeline.delivered, kStreamFrames + 1U);
  ASSERT_EQ(view->parts.size(), 1U);
  const auto& by_status = view->parts[0].by_status;
  EXPECT_EQ(by_status[0] + by_status[1] + by_status[2], kStreamFrames + 1U);
  EXPECT_GT(by_status[static_cast<std::size_t>(PoseStatus::kOk)], 10U);
  EXPECT_GE(by_status[static_cast<std::size_t>(PoseStatus::kNone)], 4U);  // failed, wrong size, hidden, unreadable
}

TEST(LiveState, PosesAreInTheFrameOfThePosesFile) {
  Extrinsics extrinsics;
  extrinsics.cam_in_body = {0, 0, 100};
  LiveState live(stream_camera(), stream_parts(), extrinsics, {});
  Watched(&live).run(1);
  live.settle();
  EXPECT_NEAR(live.view()->parts[0].latest.pose.center_in_cam.z(), 101.2, 0.05);
}

TEST(LiveState, KeepsTheNewestMessagesAndCountsAll) {
  const auto live = stream_state();
  for (int i = 0; i < 30; ++i) live->tell("number " + std::to_string(i));
  live->tell("number 20");
  const auto view = live->view();
  EXPECT_EQ(view->messages.size(), LiveState::kMostMessages);
  EXPECT_EQ(view->messages.back().text, "number 20");
  EXPECT_EQ(view->messages.back().times, 2U);
  EXPECT_EQ(view->messages_in_all, 31U);
}

TEST(LivePage, JsonHoldsTheNumbersOfThePoses) {
  const auto live = stream_state({{"Input", "bad \xff name <b>"}});
  Watched(live.get()).run(3);
  live->settle();
  const auto json = nlohmann::json::parse(to_json(*live->view(), live->facts()));
  EXPECT_EQ(json["state"], "ended");
  EXPECT_EQ(json["frame"], 2);
  EXPECT_EQ(json["picture"], 2);
  EXPECT_EQ(json["frames"]["delivered"], 3);
  EXPECT_EQ(json["parts"][0]["frames"]["ok"], 3);
  EXPECT_NEAR(json["parts"][0]["center_m"][2], 1.2, 0.05);
  EXPECT_GT(json["parts"][0]["sigma_center_m"][2], 0);
  EXPECT_EQ(json["put_to_sink"]["count"], 3);
  EXPECT_TRUE(json["cluster"].is_null());
  EXPECT_EQ(json["facts"][0]["value"], "bad \xEF\xBF\xBD name <b>");
}

TEST(LivePage, MetricsHoldWhatIsKnown) {
  LiveView view;
  view.pipeline.accepted = 7;
  view.pipeline.latency = {4, 2.5, 2, 3, 3, 3};
  LivePart part;
  part.latest.part = "a \"quoted\" \\ name\nof two lines";
  part.by_status = {1, 2, 3};
  view.parts.push_back(part);
  view.cluster.emplace().nodes.push_back({"worker.x1", 2, 5000, 11, 1});
  const std::string text = to_metrics(view);
  EXPECT_THAT(text, HasSubstr("# TYPE cylpose_frames_accepted_total counter\ncylpose_frames_accepted_total 7\n"));
  EXPECT_THAT(text, HasSubstr("cylpose_frame_latency_seconds{quantile=\"0.5\"} 0.002\n"));
  EXPECT_THAT(text, HasSubstr("cylpose_frame_latency_seconds_sum 0.01\ncylpose_frame_latency_seconds_count 4\n"));
  EXPECT_THAT(text, HasSubstr("{part=\"a \\\"quoted\\\" \\\\ name\\nof two lines\",status=\"predicted\"} 3\n"));
  EXPECT_THAT(text, Not(HasSubstr("cylpose_part_center_meters{"))) << "not of a part that was not found";
  EXPECT_THAT(text, HasSubstr("cylpose_cluster_node_tiles_total{node=\"worker.x1\",result=\"used\"} 11\n"));
  EXPECT_THAT(text, HasSubstr("cylpose_cluster_node_pixels_per_second{node=\"worker.x1\"} 5000000\n"));
}

TEST(LivePage, ServesItsFilesWithAPolicyAgainstAllElse) {
  const auto live = stream_state();
  LivePage page(*live, "127.0.0.1", 0);
  page.start();
  for (const char* path : {"/", "/live.css", "/live.js", "/icon.svg", "/metrics"}) {
    const auto file = get(page.port(), path);
    EXPECT_EQ(file.status, 200) << path;
    EXPECT_GT(file.body.size(), 50U) << path;
    EXPECT_THAT(file.head, HasSubstr("Content-Security-Policy: default-src 'none'")) << path;
    EXPECT_THAT(file.head, HasSubstr("Cache-Control: no-store")) << path;
  }
  EXPECT_EQ(get(page.port(), "/picture.jpg").status, 404) << "no frame yet";
  EXPECT_EQ(get(page.port(), "/secret").status, 404);
}

TEST(LivePage, MakesPicturesForWhoAsksAndOnePerFrame) {
  const auto live = stream_state();
  LivePage page(*live, "127.0.0.1", 0);
  page.start();
  Watched(live.get()).run(50);
  live->settle();
  EXPECT_EQ(page.pictures_made(), 0U) << "nobody has asked";
  std::string bytes;
  for (int i = 0; i < 20; ++i) {
    const auto picture = get(page.port(), "/picture.jpg?frame=49");
    EXPECT_EQ(picture.status, 200);
    EXPECT_THAT(picture.head, HasSubstr("X-Frame: 49"));
    EXPECT_EQ(picture.body.substr(0, 3), "\xff\xd8\xff");
  }
  EXPECT_EQ(page.pictures_made(), 1U);
}

// By counters, not by the clock: a pipeline that waited for these viewers would never deliver.
TEST(LivePage, ViewersThatTakeNothingDoNotHoldThePipeline) {
  const auto live = stream_state({{"Much", std::string(20'000'000, 'x')}});  // more than sockets hold
  ServerLimits limits;
  limits.write_patience = std::chrono::hours(1);
  LivePage page(*live, "127.0.0.1", 0, limits);
  page.start();
  const Connection stuck(page.port());
  stuck.send("GET /events HTTP/1.1\r\nHost: localhost\r\n\r\n");
  const Connection silent(page.port());
  EXPECT_THAT(stuck.read_until("data: {"), HasSubstr("text/event-stream"));
  Watched watched(live.get());
  watched.run(300);
  EXPECT_EQ(watched.pipeline.statistics().delivered, 300U);
  EXPECT_EQ(page.streams(), 1U) << "the viewer is still being waited for";
}

TEST(LivePage, HasOnlySoManyStreams) {
  const auto live = stream_state();
  LivePage page(*live, "127.0.0.1", 0);
  page.start();
  std::vector<std::unique_ptr<Connection>> viewers;
  for (std::size_t i = 0; i < LivePage::kMostStreams; ++i) {
    viewers.push_back(std::make_unique<Connection>(page.port()));
    viewers.back()->send("GET /events HTTP/1.1\r\nHost: localhost\r\n\r\n");
    EXPECT_THAT(viewers.back()->read_until("\n\n"), HasSubstr("\"state\":\"running\""));
  }
  EXPECT_EQ(get(page.port(), "/events").status, 503);
  EXPECT_EQ(get(page.port(), "/metrics").status, 200) << "streams leave room for requests";
  viewers.clear();
  while (page.streams() > 0) std::this_thread::yield();  // as soon as they are missed
}

TEST(LivePage, TellsViewersOfTheEnd) {
  const auto live = stream_state();
  LivePage page(*live, "127.0.0.1", 0);
  page.start();
  const Connection viewer(page.port());
  viewer.send("GET /events HTTP/1.1\r\nHost: localhost\r\n\r\n");
  EXPECT_THAT(viewer.read_until("\n\n"), HasSubstr("\"state\":\"running\""));
  Watched(live.get()).run(5);
  live->settle();
  EXPECT_THAT(viewer.read_until("\"state\":\"ended\""), HasSubstr("\"delivered\":5"));
  page.finish();
  EXPECT_THROW(Connection{page.port()}, std::system_error);
}

}  // namespace
}  // namespace cylpose::apps
