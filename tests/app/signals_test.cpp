// The steps that follow the first signal: the token, then the deadlines.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/terminal/signals.h"

#include <gtest/gtest.h>

#include <atomic>
#include <csignal>
#include <future>

namespace kindling::app {
namespace {

TEST(StopStep, FollowsTheDeadlines) {
  const StopDeadlines deadlines{.abandon_s = 1.0, .end_s = 2.0};
  EXPECT_EQ(stop_step(0.0, false, deadlines), StopStep::wait);
  EXPECT_EQ(stop_step(0.99, false, deadlines), StopStep::wait);
  EXPECT_EQ(stop_step(1.0, false, deadlines), StopStep::abandon);
  EXPECT_EQ(stop_step(1.99, false, deadlines), StopStep::abandon);
  EXPECT_EQ(stop_step(2.0, false, deadlines), StopStep::end);
  EXPECT_EQ(stop_step(2.0, true, deadlines), StopStep::abandon); // what is being stored is finished
  EXPECT_EQ(stop_step(1e6, true, deadlines), StopStep::abandon);
  EXPECT_LE(StopDeadlines().end_s, 2.0);
  EXPECT_LT(StopDeadlines().abandon_s, StopDeadlines().end_s);
}

// Waits for the watcher without a limit of time: a test that hangs has failed.
TEST(SignalGuard, EndsWorkThatHeedsNothing) {
  CancelToken token;
  std::promise<int> ended;
  {
    const SignalGuard guard(token, {.deadlines = {0.0, 0.0}, .storing = {}, .end = [&](int signal) {
                                      EXPECT_TRUE(token.abandoned());
                                      ended.set_value(signal);
                                    }});
    EXPECT_FALSE(token.cancelled());
    ASSERT_EQ(std::raise(SIGTERM), 0);
    EXPECT_TRUE(token.cancelled()); // by the handler
    EXPECT_EQ(guard.received(), SIGTERM);
    EXPECT_EQ(ended.get_future().get(), SIGTERM);
  }
}

TEST(SignalGuard, WaitsForUnfinishedStores) {
  CancelToken token;
  std::atomic<bool> storing{true};
  std::atomic<int> asked{0};
  std::promise<void> asked_often, ended;
  const SignalGuard guard(token, {.deadlines = {0.0, 0.0},
                                  .storing =
                                      [&] {
                                        if (++asked == 3) asked_often.set_value();
                                        return storing.load();
                                      },
                                  .end =
                                      [&](int) {
                                        EXPECT_FALSE(storing);
                                        ended.set_value();
                                      }});
  ASSERT_EQ(std::raise(SIGINT), 0);
  asked_often.get_future().get();
  EXPECT_TRUE(token.abandoned());
  storing = false;
  ended.get_future().get();
}

TEST(SignalGuard, WithoutASignalNothingHappens) {
  CancelToken token;
  {
    const SignalGuard guard(token, {.deadlines = {0.0, 0.0}, .storing = {}, .end = [](int) { FAIL(); }});
  }
  EXPECT_FALSE(token.cancelled());
}

} // namespace
} // namespace kindling::app
