// Decoders of BC1 to BC5: two endpoints for 4 x 4 texels, and an index for each texel.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/image/blocks/texel_block.h"

namespace kindling::image_detail {

// Khronos Data Format Specification 1.3, chapter 19 (S3TC). Colors are rounded to the nearest of 8
// bits once, after interpolation.
// `cutout`: the fourth color of blocks with three colors is transparent black instead of black.
void decode_bc1(BlockBytes block, bool cutout, TexelBlock& texels);
void decode_bc2(BlockBytes block, TexelBlock& texels); // alpha of 4 bits for each texel
void decode_bc3(BlockBytes block, TexelBlock& texels); // alpha as in BC4, rounded to 8 bits

// Chapter 20 (RGTC), unsigned. Values between the endpoints are rounded to the nearest of 16 bits,
// because they have fractions of 1/7 and 1/5.
void decode_bc4(BlockBytes block, TexelBlock& texels); // red
void decode_bc5(BlockBytes block, TexelBlock& texels); // red and green

} // namespace kindling::image_detail
