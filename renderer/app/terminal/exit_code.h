// The exit codes of the program, for scripts and render farms.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/result.h"

namespace kindling::app {

inline constexpr int kExitOk = 0;
inline constexpr int kExitRenderFailed = 1;
inline constexpr int kExitUsage = 2;
inline constexpr int kExitSceneInvalid = 3;
inline constexpr int kExitInputOutput = 4;
inline constexpr int kExitIncomplete = 5; // parts of an image are missing
inline constexpr int kExitInProgress = 6; // a farm is not done yet
// The exit code after a signal: 129 for SIGHUP, 130 for SIGINT, 143 for SIGTERM. A render still
// writes its images.
[[nodiscard]] constexpr int exit_code_of_signal(int signal) { return 128 + signal; }

[[nodiscard]] constexpr int exit_code_of(ErrorKind kind) {
  switch (kind) {
  case ErrorKind::scene_invalid: return kExitSceneInvalid;
  case ErrorKind::input_output: return kExitInputOutput;
  case ErrorKind::usage: return kExitUsage;
  case ErrorKind::render_failed: return kExitRenderFailed;
  }
  return kExitRenderFailed;
}

} // namespace kindling::app
