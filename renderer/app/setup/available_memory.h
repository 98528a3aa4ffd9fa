// The memory that this process may still take.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>

namespace kindling::app {

// Returns the available memory of the machine, or less if the control group of the process, or one
// above it, has a limit (cgroup v1 and v2). Caches that can be dropped count as available. Nothing
// if the system does not report it. `root`: folder of /proc and /sys, for tests.
[[nodiscard]] std::optional<uint64_t> available_memory_bytes(const std::filesystem::path& root = "/");

} // namespace kindling::app
