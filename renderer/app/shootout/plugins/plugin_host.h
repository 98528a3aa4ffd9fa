// The process of a plugin: builds and traces what its race asks for.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/result.h"

#include <span>

namespace kindling::app {

// True for the hidden command that starts this process.
[[nodiscard]] bool is_plugin_host(std::span<const char* const> arguments);

// Answers requests until the race ends; arguments: the command, the library, its options. Fails
// (usage) if no race started it.
[[nodiscard]] Result<int> run_plugin_host(std::span<const char* const> arguments);

} // namespace kindling::app
