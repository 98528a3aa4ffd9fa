// SIGINT, SIGTERM, SIGHUP: the first ends a render in good order, the second ends the process.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/progress.h"

namespace kindling::app {

// Handles the signals during its lifetime; at most one exists at a time. Handlers reach it through
// globals, because a signal has no other context.
class SignalGuard {
 public:
  // The first signal cancels `token`, which must outlive the guard; the second one exits with 128 +
  // its number.
  explicit SignalGuard(CancelToken& token);
  ~SignalGuard();
  SignalGuard(const SignalGuard&) = delete;
  SignalGuard& operator=(const SignalGuard&) = delete;

  // The number of the first signal that arrived, or 0.
  [[nodiscard]] int received() const;
};

// Ignores SIGPIPE and SIGXFSZ, so that writing fails where a reader closes the pipe (`kindling info
// scene.glb | head`) or a file reaches the size limit, instead of killing the process.
void ignore_signals_of_writing();

} // namespace kindling::app
