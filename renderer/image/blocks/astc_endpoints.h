// ASTC's sixteen ways to store the two endpoint colors of a subset.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <span>

namespace kindling::image_detail {

// RGBA of both endpoints: 8 bits, or 12 bits of logarithmic HDR values.
struct AstcEndpoints {
  std::array<int, 4> low, high;
  bool hdr_color = false;
  bool hdr_alpha = false;
};

// Returns the number of values of a mode, 2 to 8.
[[nodiscard]] constexpr uint32_t astc_endpoint_values(uint32_t mode) { return 2 * (mode / 4 + 1); }

// Returns the endpoints of a mode, 0 to 15, by its unquantized values (Khronos Data Format
// Specification 1.3, 23.14 and 23.15).
[[nodiscard]] AstcEndpoints astc_endpoints(uint32_t mode, std::span<const uint32_t> values);

} // namespace kindling::image_detail
