// Decoder of BC6H blocks, 4 x 4 texels of RGB as halves.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/image/blocks/texel_block.h"

namespace kindling::image_detail {

// Khronos Data Format Specification 1.3, chapter 21 (BPTC). Channels are the bits of halves, which
// are not negative unless `is_signed`; alpha is 1. A block of a reserved mode is black.
void decode_bc6h(BlockBytes block, bool is_signed, TexelBlock& texels);

} // namespace kindling::image_detail
