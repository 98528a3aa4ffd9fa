// Runs other programs without a shell: captures output, or watches them and passes signals on.
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
// Runs a program, found along PATH, to its end. Fails (input_output) if it cannot be started.
[[nodiscard]] Result<ProcessOutput> capture_process(const std::vector<std::string>& command);

// Blocks SIGTERM, SIGINT, SIGUSR1 and SIGHUP (unless that is ignored, as by nohup) during its
// lifetime and collects those that arrive. At most one may exist at a time, and it must be
// constructed before any threads.
class SignalInbox {
 public:
  SignalInbox();
  ~SignalInbox();
  SignalInbox(const SignalInbox&) = delete;
  SignalInbox& operator=(const SignalInbox&) = delete;

  // Returns the first signal received, or 0. Reads pending signals without blocking.
  int received();
  // True if this signal was received, first or later.
  [[nodiscard]] bool came(int signal);
  [[nodiscard]] int descriptor() const { return descriptor_; }

 private:
  int descriptor_ = -1;
  int first_ = 0;
  uint64_t came_ = 0; // a bit for each signal
};

struct ProcessEnd {
  int exit_code = 0;
  int signal = 0; // the signal that ended it; then exit_code is 0
};
// Runs a program in `folder` and passes both of its streams to `on_line`, line by line. A SIGTERM,
// SIGUSR1 or SIGHUP is passed on once, as SIGINT, and the program is waited for. Engines and
// terminals send a signal to all processes of a job at once, and a second one would keep the
// program from saving; so these three are blocked in it, and a SIGINT, which a terminal sends to
// both processes, is not passed on. Fails (input_output) if it cannot be started.
[[nodiscard]] Result<ProcessEnd> run_watched(const std::vector<std::string>& command,
                                             const std::filesystem::path& folder, SignalInbox& signals,
                                             const std::function<void(std::string_view)>& on_line);

} // namespace kindling
