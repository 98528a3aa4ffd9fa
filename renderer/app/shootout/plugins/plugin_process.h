// Starts the process of a plugin, sends it requests, and reports how it ended.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/app/options/plugin_spec.h"
#include "renderer/app/shootout/plugins/plugin_messages.h"
#include "renderer/app/shootout/plugins/shared_memory.h"
#include "renderer/base/progress.h"

#include <memory>
#include <optional>
#include <string>

#include <sys/types.h>

namespace kindling::app {

struct PluginLimits {
  double step_s = 60.0;                // the longest that one build, or one pass over a set of rays, may take
  const CancelToken* cancel = nullptr; // ends the process; may be null
};

class PluginProcess {
 public:
  // Starts this program again, as the host of `plugin`. Fails (render_failed) if the system has no
  // process for it.
  [[nodiscard]] static Result<std::unique_ptr<PluginProcess>>
  start(const PluginSpec& plugin, const SharedMemory& race, const SharedMemory& answers, const PluginLimits& limits);
  ~PluginProcess(); // lets it end within a second, else kills it
  PluginProcess(const PluginProcess&) = delete;
  PluginProcess& operator=(const PluginProcess&) = delete;

  // Waits for the reply. Returns nullopt, and sets fault(), if the plugin fails, if its process
  // ends, or if the time is over; it is ended then. `step` names the request, as "in a build
  // on 1 thread".
  std::optional<PluginReply> ask(const PluginRequest& request, const std::string& step);

  [[nodiscard]] const std::string& fault() const { return fault_; }

 private:
  PluginProcess(pid_t process, int messages, const PluginLimits& limits)
      : process_(process), messages_(messages), limits_(limits) {}

  // Kills the process and everything that it started, and returns its status.
  int end();

  pid_t process_ = -1;
  int messages_ = -1;
  PluginLimits limits_;
  std::string fault_;
};

} // namespace kindling::app
