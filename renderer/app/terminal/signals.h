// SIGINT and SIGTERM: the first asks the render to end in good order, the second ends the process at once.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/progress.h"

namespace kindling::app {

// Handles the signals while it lives; at most one lives at a time. Handlers reach it through the one global of the
// program, because a signal has no other context.
class SignalGuard {
 public:
  // `token` is cancelled by the first signal and must outlive the guard. The second one exits with 128 + its number.
  explicit SignalGuard(CancelToken& token);
  ~SignalGuard();
  SignalGuard(const SignalGuard&) = delete;
  SignalGuard& operator=(const SignalGuard&) = delete;

  // The number of the first signal that came, 0 if none did.
  [[nodiscard]] int received() const;
};

// A reader that closes our pipe early (`kindling info scene.glb | head`), or a limit on the size of files, makes writing fail instead of
// killing us.
void ignore_signals_of_writing();

} // namespace kindling::app
