// Decoders of ETC2 and EAC blocks, 4 x 4 texels.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/image/blocks/texel_block.h"

namespace kindling::image_detail {

// Khronos Data Format Specification 1.3, chapter 22 (ETC2 and EAC). Channels have 8 bits.
void decode_etc2_rgb(BlockBytes block, TexelBlock& texels);
void decode_etc2_cutout(BlockBytes block, TexelBlock& texels); // RGB and one bit of alpha ("punchthrough")
void decode_etc2_rgba(BlockBytes block, TexelBlock& texels);   // RGB, and alpha by EAC

// EAC, unsigned: 11 bits, rounded to the nearest of 16.
void decode_eac_r11(BlockBytes block, TexelBlock& texels);
void decode_eac_rg11(BlockBytes block, TexelBlock& texels);

} // namespace kindling::image_detail
