// Figures of memory in messages of devices.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <cstdio>
#include <string>

namespace kindling {

// "12.5 MiB"
[[nodiscard]] inline std::string mebibytes(uint64_t bytes) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.1f MiB", static_cast<double>(bytes) * 0x1p-20);
  return text.data();
}

} // namespace kindling
