// Decoder of UASTC LDR 4x4 blocks, a subset of ASTC with its own bit layout.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace kindling::image_detail {

// RGBA of 4 x 4 pixels, rows from the top.
using BlockTexels = std::array<std::array<uint8_t, 4>, 16>;

// Decodes a block (UASTC LDR 4x4 Texture Specification). Endpoints are interpolated like ASTC for
// linear data (Khronos Data Format Specification 1.3, 23.19: both widened from 8 to 16 bits by
// replication, the upper 8 bits of the result) regardless of the transfer function, because
// encoders optimize for that and the reference transcoder returns it as RGBA. Returns false for
// invalid blocks: the reserved mode, a pattern past the table, trits or quints out of range.
[[nodiscard]] bool decode_uastc_block(std::span<const std::byte, 16> block, BlockTexels& texels);

} // namespace kindling::image_detail
