// Messages of devices without their advice.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

namespace kindling {

// Returns a message of a device that cannot be opened or that failed without its advice to use the
// CPU, for callers with other advice.
[[nodiscard]] inline std::string failure_reason(std::string_view message) {
  return std::string(message.substr(0, message.find("; use --device cpu")));
}

} // namespace kindling
