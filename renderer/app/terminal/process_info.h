// What the operating system knows of this process: age and memory.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>

namespace kindling::app {

// Since the process was started, loading of shared libraries included, to 10 ms; 0 where /proc does not tell.
[[nodiscard]] double seconds_since_process_start();
// Resident memory now; 0 where /proc does not tell.
[[nodiscard]] uint64_t resident_bytes();
// Anonymous memory of this process in huge pages; 0 where /proc does not tell.
[[nodiscard]] uint64_t huge_page_bytes();
// The most that was resident since the start or the last restart_peak_resident(); 0 where /proc does not tell.
[[nodiscard]] uint64_t peak_resident_bytes();
// Gives unused memory of the heap back and starts a new peak from what is resident now; false where the system cannot.
[[nodiscard]] bool restart_peak_resident();
// "AMD EPYC ...", empty where /proc does not tell.
[[nodiscard]] std::string processor_name();

} // namespace kindling::app
