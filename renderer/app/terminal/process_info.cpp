// Reads files of /proc.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/terminal/process_info.h"

#include <malloc.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <fstream>
#include <string_view>

namespace kindling::app {

namespace {

// Reads the first bytes of a small file of /proc as text; returns false if it cannot be read.
bool read_text(const char* path, char* text, size_t size) {
  std::FILE* file = std::fopen(path, "r");
  if (!file) return false;
  const size_t count = std::fread(text, 1, size - 1, file);
  std::fclose(file);
  text[count] = '\0';
  return count > 0;
}

// Returns the rest of the line after `key` and a colon in a file of /proc; empty if there is no
// such line.
std::string find_field(const char* path, std::string_view key) {
  std::ifstream file(path);
  for (std::string line; std::getline(file, line);) {
    if (!line.starts_with(key)) continue;
    const size_t colon = line.find(':');
    const size_t begin = colon == std::string::npos ? colon : line.find_first_not_of(" \t", colon + 1);
    return begin == std::string::npos ? std::string() : line.substr(begin);
  }
  return {};
}

} // namespace

double seconds_since_process_start() {
  char text[1024];
  if (!read_text("/proc/self/stat", text, sizeof text)) return 0.0;
  // proc(5): starttime is field 22, in clock ticks since boot. Field 2 is the name in parentheses
  // and may hold spaces.
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

uint64_t huge_page_bytes() {
  return std::strtoull(find_field("/proc/self/smaps_rollup", "AnonHugePages").c_str(), nullptr, 10) * 1024U; // in kB
}

uint64_t peak_resident_bytes() {
  // Not getrusage(): its maximum includes what the process that started this one held
  // (getrusage(2), ru_maxrss after execve).
  return std::strtoull(find_field("/proc/self/status", "VmHWM").c_str(), nullptr, 10) * 1024U; // in kB
}

bool restart_peak_resident() {
  malloc_trim(0);
  // proc(5): writing 5 to clear_refs resets VmHWM to the current resident memory.
  std::FILE* file = std::fopen("/proc/self/clear_refs", "w");
  if (!file) return false;
  const bool written = std::fwrite("5", 1, 1, file) == 1;
  return std::fclose(file) == 0 && written;
}

std::string processor_name() { return find_field("/proc/cpuinfo", "model name"); }

} // namespace kindling::app
