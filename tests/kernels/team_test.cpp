#include "opencl/team.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cylpose/error.hpp>
#include <functional>
#include <map>
#include <string>
#include <utility>
#include <vector>

namespace cylpose::opencl {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::SizeIs;

enum class Step { kStart, kFind, kLocate, kWait };

class FakeWorker;

// Finds one edge a row, and a colour sum of 3 GB of light a row, so that the halves of the sums have to carry.
class FakeJob final : public StripJob {
 public:
  explicit FakeJob(FakeWorker& worker) : worker_(worker) {}

  void start(const StripTask& task) override;
  void start_finding(const StripTask& task) override;
  void start_locating(std::span<const ColorSum> colors) override;
  [[nodiscard]] bool wait() override;
  void when_done(std::function<void()> then) override;
  [[nodiscard]] bool busy() const override { return busy_; }
  [[nodiscard]] double milliseconds() const override;
  [[nodiscard]] std::span<const ColorSum> colors() const override { return colors_; }
  [[nodiscard]] std::span<const RowStatistics> rows(std::size_t) const override { return {}; }
  [[nodiscard]] std::span<const KernelEdge> edges() const override { return {}; }
  [[nodiscard]] std::span<const CylU64> mask_row(std::size_t, int) const override { return {}; }
  [[nodiscard]] std::vector<StageTime> times() const override { return {}; }

  static constexpr CylU64 kLightOfRow = 3'000'000'000;
  static CylU64 value(const ColorSum& sum) { return CylU64{sum.high[0]} << 32 | sum.low[0]; }

 private:
  FakeWorker& worker_;
  StripTask task_{};
  std::vector<ColorSum> colors_;
  bool busy_ = false;
};

class FakeWorker final : public Worker {
 public:
  explicit FakeWorker(double ms_per_row = 1) : ms_per_row_(ms_per_row) {}

  [[nodiscard]] int compute_units() const override { return 1; }
  [[nodiscard]] std::unique_ptr<StripJob> take_job() override {
    ++taken;
    return std::make_unique<FakeJob>(*this);
  }
  void give_back(std::unique_ptr<StripJob> job) override {
    ++returned;
    EXPECT_FALSE(job->busy());
  }

  void at(Step step) {
    const auto found = std::ranges::find(failing, step);
    if (found != failing.end()) throw Error(ErrorKind::kDevice, "broken");
  }

  std::vector<Step> failing;
  std::vector<std::function<void()>> ends;  ///< what when_done was told
  int room_for_rows = 1 << 20;              ///< edges a job has room for
  int taken = 0;
  int returned = 0;
  std::vector<int> rows_done;
  std::vector<CylU64> located_with;
  double ms_per_row_;
};

void FakeJob::start(const StripTask& task) {
  worker_.at(Step::kStart);
  task_ = task;
  busy_ = true;
}
void FakeJob::start_finding(const StripTask& task) {
  worker_.at(Step::kFind);
  task_ = task;
  busy_ = true;
}
void FakeJob::start_locating(std::span<const ColorSum> colors) {
  worker_.at(Step::kLocate);
  worker_.located_with.push_back(value(colors[0]));
  busy_ = true;
}
bool FakeJob::wait() {
  worker_.at(Step::kWait);
  busy_ = false;
  const int rows = task_.end_row - task_.first_row;
  if (rows > worker_.room_for_rows) {
    worker_.room_for_rows = rows;
    return false;
  }
  worker_.rows_done.push_back(rows);
  const CylU64 light = kLightOfRow * static_cast<CylU64>(rows);
  colors_.assign(1, ColorSum{});
  colors_[0].low[0] = static_cast<CylU32>(light);
  colors_[0].high[0] = static_cast<CylU32>(light >> 32);
  return true;
}
void FakeJob::when_done(std::function<void()> then) {
  worker_.ends.push_back(std::move(then));
}
double FakeJob::milliseconds() const {
  return worker_.ms_per_row_ * (task_.end_row - task_.first_row);
}

class Teams : public ::testing::Test {
 protected:
  // Wide, so that it is worth sharing.
  static StripTask frame(int rows) {
    static const std::array<KernelGate, 1> gates{};
    StripTask task{};
    task.search = {0, 0, 1 << 20, rows};
    task.end_row = rows;
    task.gates = gates;
    return task;
  }

  Team team(const std::vector<Worker*>& workers, int strip_rows = 0) {
    return Team(workers, strip_rows, [this](std::size_t worker, const std::string& why) {
      lost_.emplace_back(worker);
      EXPECT_THAT(why, HasSubstr("broken"));
    });
  }

  // Runs a frame and expects strips that cover it once, in order.
  static std::size_t expect_done(Team& team, int rows) {
    std::vector<DoneStrip> strips = team.finish(team.start(frame(rows)));
    int next = 0;
    for (DoneStrip& strip : strips) {
      EXPECT_EQ(strip.task.first_row, next);
      EXPECT_GT(strip.task.end_row, strip.task.first_row);
      next = strip.task.end_row;
      strip.lease.succeed();
    }
    EXPECT_EQ(next, rows);
    return strips.size();
  }

  std::vector<std::size_t> lost_;
};

TEST_F(Teams, OneWorkerDoesAllAtOnce) {
  FakeWorker worker;
  Team one = team({&worker});
  EXPECT_EQ(expect_done(one, 1000), 1U);
  EXPECT_TRUE(worker.located_with.empty());
  EXPECT_EQ(worker.returned, worker.taken);
}

TEST_F(Teams, SmallFramesAreNotShared) {
  FakeWorker a;
  FakeWorker b;
  Team two = team({&a, &b});
  EXPECT_EQ(expect_done(two, 20), 1U);
}

TEST_F(Teams, SharesFollowTheMeasuredSpeed) {
  FakeWorker slow(3);
  FakeWorker fast(1);
  Team two = team({&slow, &fast});
  for (int i = 0; i < 60; ++i) EXPECT_EQ(expect_done(two, 1000), 2U);
  // Done twice a frame: found and located.
  EXPECT_NEAR(slow.rows_done.back(), 250, 10);
  EXPECT_NEAR(fast.rows_done.back(), 750, 10);
}

TEST_F(Teams, EdgesAreLocatedWithTheColorOfAllStrips) {
  FakeWorker a;
  FakeWorker b;
  Team two = team({&a, &b}, 30);
  EXPECT_EQ(expect_done(two, 100), 4U);
  EXPECT_THAT(a.located_with, ElementsAre(100 * FakeJob::kLightOfRow, 100 * FakeJob::kLightOfRow));
  EXPECT_EQ(a.located_with, b.located_with);
}

TEST_F(Teams, AWorkerThatFailsAnywhereLosesItsStripsAndTheFrameIsWhole) {
  for (const Step step : {Step::kFind, Step::kLocate, Step::kWait}) {
    lost_.clear();
    FakeWorker good;
    FakeWorker bad;
    bad.failing = {step};
    Team two = team({&bad, &good}, 10);
    EXPECT_EQ(expect_done(two, 100), 10U);
    EXPECT_THAT(lost_, ElementsAre(0)) << "reported once";
    EXPECT_EQ(good.located_with, std::vector<CylU64>(10, 100 * FakeJob::kLightOfRow));
    const int taken = bad.taken;
    EXPECT_EQ(expect_done(two, 100), 10U);
    EXPECT_EQ(bad.taken, taken) << "not asked again";
    EXPECT_THAT(lost_, SizeIs(1));
  }
}

TEST_F(Teams, WhereNobodyIsLeftItIsAnError) {
  FakeWorker a;
  FakeWorker b;
  a.failing = b.failing = {Step::kWait};
  Team two = team({&a, &b}, 10);
  EXPECT_THROW(static_cast<void>(two.finish(two.start(frame(100)))), Error);
  EXPECT_THAT(lost_, ElementsAre(0, 1));
  EXPECT_THROW(static_cast<void>(two.finish(two.start(frame(100)))), Error);
}

TEST_F(Teams, AnOnlyWorkerMayRecover) {
  FakeWorker worker;
  worker.failing = {Step::kStart};
  Team one = team({&worker});
  EXPECT_THROW(static_cast<void>(one.finish(one.start(frame(100)))), Error);
  worker.failing.clear();
  EXPECT_EQ(expect_done(one, 100), 1U);
  EXPECT_TRUE(lost_.empty());
}

TEST_F(Teams, ARunIsDoneWhenAllItsStripsAre) {
  FakeWorker a;
  FakeWorker b;
  a.failing = {Step::kFind};  // a start that failed keeps nobody waiting
  Team two = team({&a, &b}, 10);
  Team::Run run = two.start(frame(40));
  int done = 0;
  run.when_done([&] { ++done; });
  ASSERT_THAT(b.ends, SizeIs(2));
  EXPECT_THAT(a.ends, SizeIs(0));
  b.ends[0]();
  EXPECT_EQ(done, 0);
  b.ends[1]();
  EXPECT_EQ(done, 1);
  EXPECT_THAT(two.finish(std::move(run)), SizeIs(4));
}

TEST_F(Teams, MoreEdgesThanRoomAreStartedAgain) {
  FakeWorker a;
  FakeWorker b;
  a.room_for_rows = b.room_for_rows = 5;
  Team two = team({&a, &b}, 10);
  EXPECT_EQ(expect_done(two, 100), 10U);
  Team one = team({&a});
  EXPECT_EQ(expect_done(one, 400), 1U);
  EXPECT_TRUE(lost_.empty());
}

}  // namespace
}  // namespace cylpose::opencl
