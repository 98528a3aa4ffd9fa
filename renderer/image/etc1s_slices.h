// Decoder of BasisLZ/ETC1S slices, which give the endpoint and the selector of each block.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/image/etc1s_codebooks.h"

#include <cstdint>
#include <functional>

namespace kindling::image_detail {

// Receives a block; x and y are its column and row, in blocks.
using Etc1sBlockSink =
    std::function<void(uint32_t x, uint32_t y, const Etc1sEndpoint& endpoint, const Etc1sSelector& selector)>;

// Decodes a slice of a still image (KTX 2.0, "ETC1S Slice Decoding"). Calls `sink` for all blocks,
// in rows from the top. Returns false if the slice is damaged, possibly after some calls of `sink`.
[[nodiscard]] bool decode_etc1s_slice(Bytes slice, const Etc1sData& data, uint32_t blocks_x, uint32_t blocks_y,
                                      const Etc1sBlockSink& sink);

} // namespace kindling::image_detail
