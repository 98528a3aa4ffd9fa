// Reads /proc/meminfo and the limits of control groups.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/setup/available_memory.h"

#include <algorithm>
#include <fstream>
#include <string>
#include <string_view>

namespace kindling::app {

namespace {

namespace fs = std::filesystem;

// Returns the number that a file holds; nothing for "max", or if there is no such file.
std::optional<uint64_t> read_number(const fs::path& path) {
  std::ifstream file(path);
  uint64_t value = 0;
  if (!(file >> value)) return std::nullopt;
  return value;
}

// Returns the number after `key` in a file of lines.
std::optional<uint64_t> read_field(const fs::path& path, std::string_view key) {
  std::ifstream file(path);
  for (std::string word; file >> word;) {
    uint64_t value = 0;
    if (word == key && file >> value) return value;
    file.clear();
  }
  return std::nullopt;
}

// Returns the memory that a group leaves below its limit; nothing without a limit.
std::optional<uint64_t> left_in_group(const fs::path& group, const char* limit, const char* usage, const char* cache) {
  const std::optional<uint64_t> max = read_number(group / limit), used = read_number(group / usage);
  if (!max || !used) return std::nullopt;
  const uint64_t dropped = std::min(*used, read_field(group / "memory.stat", cache).value_or(0));
  return *max - std::min(*max, *used - dropped);
}

} // namespace

std::optional<uint64_t> available_memory_bytes(const fs::path& root) {
  std::optional<uint64_t> available;
  const auto limit = [&](std::optional<uint64_t> bytes) {
    if (bytes) available = std::min(*bytes, available.value_or(*bytes));
  };
  if (const auto kibibytes = read_field(root / "proc/meminfo", "MemAvailable:")) limit(*kibibytes * 1024);

  // proc(5): lines "number:controllers:/path"; of v2 the number is 0 and there are no controllers.
  std::ifstream groups(root / "proc/self/cgroup");
  for (std::string line; std::getline(groups, line);) {
    const size_t first = line.find(':'), second = line.find(':', first + 1);
    if (second == std::string::npos || line.size() < second + 2) continue;
    const std::string controllers = line.substr(first + 1, second - first - 1);
    const bool v1 = ("," + controllers + ",").find(",memory,") != std::string::npos;
    if (!v1 && !controllers.empty()) continue;
    const fs::path mount = root / (v1 ? "sys/fs/cgroup/memory" : "sys/fs/cgroup");
    for (fs::path group = fs::path(line.substr(second + 1)).relative_path();; group = group.parent_path()) {
      limit(v1 ? left_in_group(mount / group, "memory.limit_in_bytes", "memory.usage_in_bytes", "total_inactive_file")
               : left_in_group(mount / group, "memory.max", "memory.current", "inactive_file"));
      if (group.empty()) break;
    }
  }
  return available;
}

} // namespace kindling::app
