// Tests of running other programs: arguments, streams, exit codes and signals.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/distributed/run_process.h"

#include <gtest/gtest.h>

#include <csignal>

namespace kindling::test {
namespace {

TEST(CaptureProcess, ArgumentsBypassTheShell) {
  const Result<ProcessOutput> output = capture_process({"printf", "%s|", "a b", "$HOME", "'"});
  ASSERT_TRUE(output.ok()) << output.error().message;
  EXPECT_EQ(output.value().out, "a b|$HOME|'|");
  EXPECT_EQ(output.value().exit_code, 0);
}

TEST(CaptureProcess, SeparatesStreamsAndReportsExitCode) {
  const Result<ProcessOutput> output =
      capture_process({"sh", "-c", "echo out; echo err >&2; head -c 300000 /dev/zero; exit 7"});
  ASSERT_TRUE(output.ok());
  EXPECT_EQ(output.value().out.size(), 300004u);
  EXPECT_EQ(output.value().err, "err\n");
  EXPECT_EQ(output.value().exit_code, 7);
  EXPECT_EQ(capture_process({"sh", "-c", "kill -9 $$"}).value().exit_code, 137);
}

TEST(CaptureProcess, MissingProgramIsAnError) {
  const Result<ProcessOutput> output = capture_process({"kindling-no-such-program"});
  ASSERT_FALSE(output.ok());
  EXPECT_NE(output.error().message.find("kindling-no-such-program: cannot be run: No such file"), std::string::npos)
      << output.error().message;
}

TEST(RunWatched, PassesLinesAndUsesFolder) {
  SignalInbox signals;
  std::vector<std::string> lines;
  const Result<ProcessEnd> end = run_watched({"sh", "-c", "pwd; echo two >&2; printf three; exit 5"}, "/", signals,
                                             [&](std::string_view line) { lines.emplace_back(line); });
  ASSERT_TRUE(end.ok()) << end.error().message;
  EXPECT_EQ(lines, (std::vector<std::string>{"/", "two", "three"}));
  EXPECT_EQ(end.value().exit_code, 5);
  EXPECT_EQ(run_watched({"sh", "-c", "kill -SEGV $$"}, "/", signals, [](std::string_view) {}).value().signal, 11);
}

TEST(SignalInbox, ReportsFirstSignalAndRemembersOthers) {
  SignalInbox signals;
  EXPECT_EQ(signals.received(), 0);
  raise(SIGUSR1);
  EXPECT_EQ(signals.received(), SIGUSR1);
  EXPECT_FALSE(signals.came(SIGTERM));
  raise(SIGTERM);
  EXPECT_EQ(signals.received(), SIGUSR1);
  EXPECT_TRUE(signals.came(SIGTERM));
  EXPECT_FALSE(signals.came(SIGINT));
}

TEST(SignalInbox, CollectsHangUpUnlessIgnored) {
  {
    SignalInbox signals;
    raise(SIGHUP);
    EXPECT_EQ(signals.received(), SIGHUP);
  }
  const auto before = std::signal(SIGHUP, SIG_IGN); // as nohup does
  {
    SignalInbox signals;
    raise(SIGHUP);
    EXPECT_EQ(signals.received(), 0);
  }
  std::signal(SIGHUP, before);
}

// The render gets one SIGINT, which saves, as for SIGTERM.
TEST(RunWatched, PassesHangUpOnAsInterrupt) {
  SignalInbox signals;
  std::vector<std::string> lines;
  const Result<ProcessEnd> end =
      run_watched({"sh", "-c", "trap 'echo saved; exit 130' INT; echo ready; while :; do sleep 0.05; done"}, "/",
                  signals, [&](std::string_view line) {
                    lines.emplace_back(line);
                    if (line == "ready") raise(SIGHUP);
                  });
  ASSERT_TRUE(end.ok()) << end.error().message;
  EXPECT_EQ(lines, (std::vector<std::string>{"ready", "saved"}));
  EXPECT_EQ(end.value().exit_code, 130);
}

} // namespace
} // namespace kindling::test
