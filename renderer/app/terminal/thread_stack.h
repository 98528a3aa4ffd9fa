// Enough stack for the program's threads, whatever `ulimit -s` says.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/result.h"

#include <functional>

namespace kindling::app {

// Calls `work` and returns its value. If the stack limit of the process is below the usual 8 MiB,
// `work` runs in a thread of its own with a stack of that size, as later threads have, too. Fails
// (render_failed) if that thread cannot be started. Signals reach `work`'s thread. Call it once,
// before there are other threads; `work` must not throw.
[[nodiscard]] Result<int> call_with_enough_stack(const std::function<int()>& work);

} // namespace kindling::app
