// Age, memory and processor of this process, as the operating system reports them.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>

namespace kindling::app {

// Seconds since the process was started, loading of shared libraries included, to 10 ms. This and
// all of the following return 0 if /proc cannot be read.
[[nodiscard]] double seconds_since_process_start();
// Resident memory now.
[[nodiscard]] uint64_t resident_bytes();
// Anonymous memory of this process in huge pages.
[[nodiscard]] uint64_t huge_page_bytes();
// The peak of resident memory since the start or the last restart_peak_resident().
[[nodiscard]] uint64_t peak_resident_bytes();
// Returns unused heap memory to the system and starts a new peak from the current resident memory;
// false if the system does not support this.
[[nodiscard]] bool restart_peak_resident();
// "AMD EPYC ...", or an empty string.
[[nodiscard]] std::string processor_name();

} // namespace kindling::app
