// Running other programs: arguments as they are, no shell in between.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/result.h"

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

namespace kindling {

struct ProcessOutput {
  int exit_code = 0; // 128 + the signal that ended it
  std::string out;
  std::string err;
};
// Runs a program, found along PATH, to its end. Fails (input_output) where it cannot be started.
[[nodiscard]] Result<ProcessOutput> capture_process(const std::vector<std::string>& command);

// Blocks SIGTERM, SIGINT and SIGUSR1 while it lives and keeps those that come. At most one lives at a time; threads are started later.
class SignalInbox {
 public:
  SignalInbox();
  ~SignalInbox();
  SignalInbox(const SignalInbox&) = delete;
  SignalInbox& operator=(const SignalInbox&) = delete;

  // The first signal that came, 0 if none did. Takes what waits without blocking.
  int received();
  // Whether this one has come, first or later.
  [[nodiscard]] bool came(int signal);
  [[nodiscard]] int descriptor() const { return descriptor_; }

 private:
  int descriptor_ = -1;
  int first_ = 0;
  uint64_t came_ = 0; // a bit for each
};

struct ProcessEnd {
  int exit_code = 0;
  int signal = 0; // that ended it; exit_code is 0 then
};
// Runs a program in `folder` with both streams going to `on_line` line by line. A SIGTERM or SIGUSR1 is passed on once, as SIGINT, and the
// program is waited for: engines and terminals send a signal to all processes of a job at once, and a second one would keep the program from
// saving what it has; so SIGTERM and SIGUSR1 are blocked in it, and a SIGINT, which a terminal sends to both, is not passed on.
// Fails (input_output) where it cannot be started.
[[nodiscard]] Result<ProcessEnd> run_watched(const std::vector<std::string>& command,
                                             const std::filesystem::path& folder, SignalInbox& signals,
                                             const std::function<void(std::string_view)>& on_line);

} // namespace kindling
