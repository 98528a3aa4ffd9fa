// Slices of BasisLZ/ETC1S: for each block of an image, which endpoint and which selector it uses.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/image/etc1s_codebooks.h"

#include <cstdint>
#include <functional>

namespace kindling::image_detail {

// Column and row of the block, in blocks.
using Etc1sBlockSink =
    std::function<void(uint32_t x, uint32_t y, const Etc1sEndpoint& endpoint, const Etc1sSelector& selector)>;

// KTX 2.0, "ETC1S Slice Decoding", of an image that is no part of a video. Calls `sink` for the blocks in rows from the
// top. False if the slice is damaged: `sink` may have seen some blocks then.
[[nodiscard]] bool decode_etc1s_slice(Bytes slice, const Etc1sData& data, uint32_t blocks_x, uint32_t blocks_y,
                                      const Etc1sBlockSink& sink);

} // namespace kindling::image_detail
