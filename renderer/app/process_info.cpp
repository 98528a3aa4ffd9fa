// What the operating system knows of this process, read from /proc and getrusage().
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/process_info.h"

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <cstring>
#include <ctime>

namespace kindling::app {

namespace {

// The first bytes of a small file of /proc as text; false if it cannot be read.
bool read_text(const char* path, char* text, size_t size) {
  std::FILE* file = std::fopen(path, "r");
  if (!file) return false;
  const size_t count = std::fread(text, 1, size - 1, file);
  std::fclose(file);
  text[count] = '\0';
  return count > 0;
}

} // namespace

double seconds_since_process_start() {
  char text[1024];
  if (!read_text("/proc/self/stat", text, sizeof text)) return 0.0;
  // proc(5): starttime is field 22, in clock ticks since boot. Field 2 is the name in parentheses and may hold spaces.
  const char* at = std::strrchr(text, ')');
  for (int field = 2; at && field < 22; ++field) at = std::strchr(at + 1, ' ');
  unsigned long long ticks = 0;
  timespec now{};
  if (!at || std::sscanf(at, "%llu", &ticks) != 1 || clock_gettime(CLOCK_BOOTTIME, &now) != 0) return 0.0;
  const double started = static_cast<double>(ticks) / static_cast<double>(sysconf(_SC_CLK_TCK));
  return std::max(0.0, static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec) - started);
}

uint64_t resident_bytes() {
  char text[256];
  unsigned long long pages = 0;
  if (!read_text("/proc/self/statm", text, sizeof text) || std::sscanf(text, "%*u %llu", &pages) != 1) return 0;
  return pages * static_cast<uint64_t>(sysconf(_SC_PAGESIZE));
}

uint64_t peak_resident_bytes() {
  rusage usage{};
  if (getrusage(RUSAGE_SELF, &usage) != 0) return 0;
  return static_cast<uint64_t>(usage.ru_maxrss) * 1024U; // Linux counts in KiB
}

} // namespace kindling::app
