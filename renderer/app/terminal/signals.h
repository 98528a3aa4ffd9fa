// SIGINT, SIGTERM, SIGHUP: the first ends a render in good order, the second ends the process.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/progress.h"

#include <functional>
#include <thread>

namespace kindling::app {

// The step that is due some time after the first signal: wait for the work to end by itself, drop
// the work in hand, or end the process.
enum class StopStep { wait, abandon, end };
struct StopDeadlines {
  double abandon_s = 1.0;
  double end_s = 1.5;
};
// `storing`: results are being stored, which is always finished.
[[nodiscard]] StopStep stop_step(double since_signal_s, bool storing, const StopDeadlines& deadlines = {});

// Acts on the deadlines. Functions are called from a thread of its own.
struct StopEnforcement {
  StopDeadlines deadlines;
  std::function<bool()> storing;       // whether results are being stored
  std::function<void(int signal)> end; // ends the process
};

// Handles the signals during its lifetime; at most one exists at a time. Handlers reach it through
// globals, because a signal has no other context.
class SignalGuard {
 public:
  // The first signal cancels `token`, which must outlive the guard; the second one exits with 128 +
  // its number.
  explicit SignalGuard(CancelToken& token);
  // With an enforcement the first signal also ends work that does not heed the token: it is
  // abandoned, and then the process is ended.
  SignalGuard(CancelToken& token, StopEnforcement enforcement);
  ~SignalGuard();
  SignalGuard(const SignalGuard&) = delete;
  SignalGuard& operator=(const SignalGuard&) = delete;

  // The number of the first signal that arrived, or 0.
  [[nodiscard]] int received() const;

 private:
  std::jthread watcher_; // of the deadlines, if they are enforced
};

// Ignores SIGPIPE and SIGXFSZ, so that writing fails where a reader closes the pipe (`kindling info
// scene.glb | head`) or a file reaches the size limit, instead of killing the process.
void ignore_signals_of_writing();

} // namespace kindling::app
