// Codebooks of BasisLZ/ETC1S: endpoints and selectors that the blocks of all slices refer to.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/result.h"
#include "renderer/image/basis_lz_bits.h"

#include <array>
#include <cassert>
#include <cstdint>
#include <vector>

namespace kindling::image_detail {

// The base color of a block, 5 bits per channel, and its row of ETC1's intensity modifiers (0 to
// 7).
struct Etc1sEndpoint {
  std::array<uint8_t, 3> color{};
  uint8_t intensity = 0;
};

// Two bits for each of 4 x 4 pixels, a byte for each row. Values 0 to 3 select modifiers from the
// darkest to the brightest.
struct Etc1sSelector {
  std::array<uint8_t, 4> rows{};
  [[nodiscard]] size_t at(size_t pixel) const {
    assert(pixel < 16);
    return rows[pixel / 4] >> (2 * (pixel % 4)) & 3U;
  }
};

// The bytes of a slice within level 0.
struct Etc1sSliceRange {
  uint32_t offset = 0, length = 0; // bytes
};

// The data outside of the slices ("BasisLZ Global Data").
struct Etc1sData {
  Etc1sSliceRange color_slice, alpha_slice; // of level 0; alpha_slice.length is 0 if there is none
  std::vector<Etc1sEndpoint> endpoints;
  std::vector<Etc1sSelector> selectors;
  HuffmanTable endpoint_prediction, endpoint_delta, selector_or_history, selector_run;
  uint32_t history_size = 0; // number of recent selectors
};

// Reads the global data (KTX 2.0, "BasisLZ Global Data" and "BasisLZ/ETC1S Bitstream
// Specification"). `images` is the number of images in the file, level 0 first. Video frames that
// depend on another frame are refused. Errors contain the detail only.
[[nodiscard]] Result<Etc1sData> read_etc1s_data(Bytes globals, uint32_t images);

// Returns the four 8-bit RGB colors of a block (Khronos Data Format Specification 1.3, 21.1).
[[nodiscard]] std::array<std::array<uint8_t, 3>, 4> etc1s_colors(const Etc1sEndpoint& endpoint);

} // namespace kindling::image_detail
