// A contiguous range of sample indices of a pixel, half-open.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <compare>
#include <cstdint>

namespace kindling {

// The samples [first, end) of a pixel.
struct SampleRange {
  uint32_t first = 0;
  uint32_t end = 0;
  [[nodiscard]] constexpr uint32_t count() const { return end - first; }
  [[nodiscard]] constexpr bool empty() const { return end <= first; }
  auto operator<=>(const SampleRange&) const = default; // by first, then by end
};

} // namespace kindling
