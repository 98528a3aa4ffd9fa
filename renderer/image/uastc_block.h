// Blocks of UASTC LDR 4x4: a subset of ASTC in a layout of its own.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace kindling::image_detail {

// RGBA of 4 x 4 pixels, rows from the top.
using BlockTexels = std::array<std::array<uint8_t, 4>, 16>;

// UASTC LDR 4x4 Texture Specification. Endpoints are interpolated as ASTC does for linear data (Khronos Data Format
// Specification 1.3, 23.19: both 8 bits widened to 16 by replication, the upper 8 bits of the result kept), whatever
// the transfer function: what encoders optimize for, and what the reference transcoder gives as RGBA. False for a block
// that no encoder writes: the reserved mode, a pattern past the table, trits or quints out of range.
[[nodiscard]] bool decode_uastc_block(std::span<const std::byte, 16> block, BlockTexels& texels);

} // namespace kindling::image_detail
