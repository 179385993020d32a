#include "cost_model.hpp"

#include <gtest/gtest.h>

#include "share_judge.hpp"

namespace cylpose::cluster {
namespace {

CostModel learnt(double fixed_ms, double ms_per_mpixel) {
  CostModel model;
  for (int i = 0; i < 20; ++i) {
    const double pixels = i % 2 == 0 ? 20'000 : 80'000;
    model.add(pixels, fixed_ms + ms_per_mpixel * pixels * 1e-6);
  }
  return model;
}

TEST(CostModel, SeparatesWhatIsFixedFromWhatGrows) {
  const CostModel model = learnt(1.5, 10);
  EXPECT_NEAR(model.ms(0), 1.5, 1e-9);
  EXPECT_NEAR(model.ms(1'000'000), 11.5, 1e-9);
  EXPECT_EQ(CostModel().ms(1000), 0);
  EXPECT_FALSE(CostModel().known());
}

TEST(CostModel, OneSizeTellsHalfFixed) {
  CostModel model;
  model.add(100, 4);
  model.add(100, 4);
  EXPECT_DOUBLE_EQ(model.ms(100), 4);
  EXPECT_DOUBLE_EQ(model.ms(200), 6);
}

TEST(CostModel, FollowsANodeThatBecomesSlow) {
  CostModel model = learnt(1, 10);
  for (int i = 0; i < 30; ++i) model.add(50'000, 100);
  EXPECT_GT(model.ms(50'000), 90);
}

TEST(CostModel, NeverFallsWithMorePixels) {
  CostModel model;
  model.add(100, 10);
  model.add(1000, 1);
  EXPECT_GE(model.ms(1000), model.ms(100));
  EXPECT_GE(model.ms(0), 0);
}

TEST(WorthSending, NothingWhereTheLocalDeviceIsQuickerAnyway) {
  const HomeCosts home{learnt(0, 1), learnt(0, 0.1)};
  EXPECT_TRUE(worth_sending(720, 1280, 64, home, {{learnt(2, 1), 2}}).empty());
  EXPECT_TRUE(worth_sending(720, 1280, 64, home, {}).empty());
  EXPECT_TRUE(worth_sending(720, 1280, 64, HomeCosts(), {{learnt(0, 0), 8}}).empty());
  EXPECT_TRUE(worth_sending(720, 1280, 64, home, {{CostModel(), 8}}).empty());
}

TEST(WorthSending, SharesSoThatAllAreDoneAtAboutTheSameTime) {
  const HomeCosts home{learnt(0, 100), learnt(0, 1)};
  const auto plan = worth_sending(800, 1000, 50, home, {{learnt(1, 100), 16}});
  ASSERT_GE(plan.size(), 6U);
  EXPECT_LE(plan.size(), 8U);
  int end = 800;
  for (const Assignment& tile : plan) {
    EXPECT_EQ(tile.rows.end, end);
    EXPECT_EQ(tile.rows.end - tile.rows.first, 50);
    end = tile.rows.first;
  }
}

TEST(WorthSending, FasterNodesGetMoreAndNobodyMoreThanAskedFor) {
  const HomeCosts home{learnt(0, 1000), learnt(0, 1)};
  const auto plan = worth_sending(800, 1000, 50, home, {{learnt(1, 100), 3}, {learnt(1, 50), 16}});
  const auto of = [&](std::size_t node) { return std::ranges::count(plan, node, &Assignment::offer); };
  EXPECT_LE(of(0), 3);
  EXPECT_GT(of(1), of(0));
}

TEST(ShareJudge, StopsWhatIsSlowerAndTriesAgainEverLessOften) {
  ShareJudge judge;
  judge.alone(1);
  int attempts = 0;
  for (int frame = 0; frame < 2000; ++frame) {
    if (judge.allows_sharing()) {
      ++attempts;
      judge.shared(2);
    } else {
      judge.alone(1);
    }
  }
  EXPECT_GE(attempts, 4);
  EXPECT_LE(attempts, 8);
}

TEST(ShareJudge, KeepsWhatIsQuicker) {
  ShareJudge judge;
  judge.alone(1);
  for (int frame = 0; frame < 100; ++frame) {
    ASSERT_TRUE(judge.allows_sharing());
    judge.shared(0.5);
  }
}

}  // namespace
}  // namespace cylpose::cluster
