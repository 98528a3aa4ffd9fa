// Decoder of two-dimensional ASTC blocks of 4 x 4 to 12 x 12 texels.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/image/blocks/texel_block.h"

namespace kindling::image_detail {

// The channels of a texture: 8 bits of linear or sRGB values, or halves.
enum class AstcProfile : uint8_t { linear, srgb, hdr };

// Decodes a block (Khronos Data Format Specification 1.3, chapter 23). Channels of the first two
// profiles are the upper 8 of 16 bits ("decode_unorm8"), those of the third the bits of halves.
// Returns false for blocks that the specification calls illegal, which includes HDR texels in the
// other profiles.
[[nodiscard]] bool decode_astc(BlockBytes block, uint32_t width, uint32_t height, AstcProfile profile,
                               TexelBlock& texels);

} // namespace kindling::image_detail
