#include "search_plan.hpp"

#include <gtest/gtest.h>

#include "stream.hpp"

namespace cylpose::graph {
namespace {

using testing::stream_camera;
using testing::stream_parts;

const Roi kWhole{0, 0, 200, 150};

FrameTask numbered(std::uint64_t sequence) {
  FrameTask frame;
  frame.sequence = sequence;
  frame.timestamp_s = static_cast<double>(sequence) / 30;
  frame.estimate.parts.resize(1);
  return frame;
}

FrameTask seen_at(std::uint64_t sequence, double x_m) {
  FrameTask frame = numbered(sequence);
  PoseEstimate& part = frame.estimate.parts[0];
  part.status = PoseStatus::kOk;
  part.pose = {{x_m, 0, 1.2}, {0, -1, 0}};
  return frame;
}

Roi region_of(double x_m) {
  SearchRegion region(stream_camera());
  region.update(stream_parts(), seen_at(0, x_m).estimate.parts);
  return region.next();
}

TEST(SearchPlan, LooksWhereTheFrameALagAgoWasAndNoLaterOne) {
  SearchPlan plan(stream_camera(), stream_parts(), 3, std::nullopt);
  const auto place = [](std::uint64_t sequence) { return 0.01 * static_cast<double>(sequence); };
  for (std::uint64_t k = 0; k < 12; ++k) {
    EXPECT_EQ(plan.region(numbered(k)), k < 3 ? kWhole : region_of(place(k - 3)));
    FrameTask frame = seen_at(k, place(k));
    // Everything of the frames before k is known already, as with a slow source.
    plan.take_in(frame);
  }
}

TEST(SearchPlan, AFailedFrameSaysNothing) {
  SearchPlan plan(stream_camera(), stream_parts(), 1, std::nullopt);
  FrameTask seen = seen_at(0, 0.05);
  plan.take_in(seen);
  FrameTask failed = numbered(1);
  failed.failure = Error(ErrorKind::kInput, "no image");
  plan.take_in(failed);
  EXPECT_EQ(plan.region(numbered(2)), region_of(0.05));
  FrameTask empty = numbered(2);
  plan.take_in(empty);
  EXPECT_EQ(plan.region(numbered(3)), kWhole) << "looked for and not found";
}

}  // namespace
}  // namespace cylpose::graph
