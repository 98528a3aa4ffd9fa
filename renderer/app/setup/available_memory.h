// How much memory this process may still take.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>

namespace kindling::app {

// What the machine has available, or less where the control group that the process is in, or one above it, has a limit (cgroup v2, and
// v1 as Linux still offers it); caches that can be dropped count as free. Nothing where the system does not tell. `root`: of /proc and
// /sys, for tests.
[[nodiscard]] std::optional<uint64_t> available_memory_bytes(const std::filesystem::path& root = "/");

} // namespace kindling::app
