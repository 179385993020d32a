#include "opencl/watchdog.hpp"

#include <gtest/gtest.h>

#include <future>
#include <vector>

namespace cylpose::opencl {
namespace {

using std::chrono::milliseconds;

TEST(Watchdog, CallsWhatIsDueAndNotWhatWasDismissed) {
  Watchdog watchdog;
  std::promise<void> late;
  const auto now = Watchdog::Clock::now();
  const auto ticket = watchdog.add(now + milliseconds(5), [] { ADD_FAILURE() << "it was dismissed"; });
  watchdog.dismiss(ticket);
  static_cast<void>(watchdog.add(now + milliseconds(10), [&] { late.set_value(); }));
  late.get_future().wait();
  EXPECT_GE(Watchdog::Clock::now(), now + milliseconds(10));
  watchdog.dismiss(ticket);  // once more does no harm
}

TEST(Watchdog, AnEarlierDeadlineIsNotHeldUpByALaterOne) {
  Watchdog watchdog;
  const auto now = Watchdog::Clock::now();
  std::promise<int> first;
  static_cast<void>(watchdog.add(now + std::chrono::hours(1), [&] { first.set_value(2); }));
  static_cast<void>(watchdog.add(now + milliseconds(1), [&] { first.set_value(1); }));
  EXPECT_EQ(first.get_future().get(), 1);
}

TEST(Watchdog, EndsWithDeadlinesOpenAndWithoutAny) {
  const Watchdog unused;
  Watchdog watchdog;
  static_cast<void>(watchdog.add(Watchdog::Clock::now() + std::chrono::hours(1), [] { ADD_FAILURE(); }));
}

}  // namespace
}  // namespace cylpose::opencl
