#include "intake.hpp"

#include <gtest/gtest.h>

#include <future>

namespace cylpose::graph {
namespace {

FramePtr frame(std::int64_t id) {
  auto task = std::make_shared<FrameTask>();
  task->id = id;
  return task;
}

TEST(Intake, StartsAsManyAsTheLagAllowsAndNumbersThem) {
  Intake intake(Policy::kAll, 2);
  for (int i = 0; i < 3; ++i) EXPECT_TRUE(intake.put(frame(10 + i), false));
  EXPECT_EQ(intake.next()->id, 10);
  EXPECT_EQ(intake.next()->sequence, 1U);
  EXPECT_EQ(intake.next(), nullptr) << "two are at work";
  intake.solved();
  EXPECT_EQ(intake.next()->id, 12);
  EXPECT_EQ(intake.next(), nullptr);
}

TEST(Intake, OfARecordingIsFullUntilFramesHaveLeft) {
  Intake intake(Policy::kAll, 1);
  for (int i = 0; i < 3; ++i) EXPECT_TRUE(intake.put(frame(i), false));
  EXPECT_FALSE(intake.put(frame(3), false));
  EXPECT_NE(intake.next(), nullptr);
  intake.solved();
  EXPECT_FALSE(intake.put(frame(3), false)) << "the sink still has it";
  intake.left(true);
  EXPECT_TRUE(intake.put(frame(3), false));
  EXPECT_EQ(intake.counts().accepted, 4U);
  EXPECT_EQ(intake.counts().dropped, 0U);
}

TEST(Intake, OfALiveStreamReplacesTheOneThatWaits) {
  Intake intake(Policy::kLatest, 1);
  EXPECT_TRUE(intake.put(frame(0), false));
  EXPECT_EQ(intake.next()->id, 0);
  for (int i = 1; i < 5; ++i) EXPECT_TRUE(intake.put(frame(i), false));
  EXPECT_EQ(intake.counts().dropped, 3U);
  intake.solved();
  EXPECT_EQ(intake.next(), nullptr) << "the sink is behind";
  intake.left(true);
  const FramePtr newest = intake.next();
  EXPECT_EQ(newest->id, 4);
  EXPECT_EQ(newest->sequence, 1U) << "without gaps";
}

TEST(Intake, ClosedItDropsWhatWaitsAndLetsNobodyIn) {
  Intake intake(Policy::kAll, 1);
  for (int i = 0; i < 3; ++i) EXPECT_TRUE(intake.put(frame(i), false));
  EXPECT_NE(intake.next(), nullptr);
  auto waits = std::async(std::launch::async, [&] { return intake.put(frame(3), true); });
  intake.close();
  EXPECT_FALSE(waits.get());
  EXPECT_EQ(intake.next(), nullptr);
  EXPECT_EQ(intake.counts().dropped, 2U);
  auto empty = std::async(std::launch::async, [&] { intake.wait_until_empty(); });
  intake.solved();
  intake.left(false);
  empty.get();
  EXPECT_EQ(intake.counts().delivered, 0U);
}

}  // namespace
}  // namespace cylpose::graph
