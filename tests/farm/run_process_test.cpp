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

} // namespace
} // namespace kindling::test
