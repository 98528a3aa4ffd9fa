// What the operating system knows of this process: age and memory.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace kindling::app {

// Since the process was started, loading of shared libraries included, to 10 ms; 0 where /proc does not tell.
[[nodiscard]] double seconds_since_process_start();
// Resident memory now; 0 where /proc does not tell.
[[nodiscard]] uint64_t resident_bytes();
// The most that was ever resident.
[[nodiscard]] uint64_t peak_resident_bytes();

} // namespace kindling::app
