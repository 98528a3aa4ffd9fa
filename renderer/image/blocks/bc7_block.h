// Decoder of BC7 blocks, 4 x 4 texels of RGBA in eight modes.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/image/blocks/texel_block.h"

namespace kindling::image_detail {

// Khronos Data Format Specification 1.3, chapter 21 (BPTC). Channels have 8 bits; a block of the
// reserved mode is transparent black, as the specification says.
void decode_bc7(BlockBytes block, TexelBlock& texels);

} // namespace kindling::image_detail
