// Blocks all over an image, for pilots.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/film/film.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace kindling {

// A grid of square cells over an image, with one square block of pixels, cut off at the image's
// edges, at a random place in each.
struct PilotGrid {
  [[nodiscard]] size_t cell_of(int x, int y) const {
    return static_cast<size_t>(y / side) * static_cast<size_t>(columns) + static_cast<size_t>(x / side);
  }

  int side = 0; // of a cell, in pixels: a multiple of that of a block
  int columns = 0;
  std::vector<PixelRect> blocks; // by cell
};

// Returns the grid of the smallest cells of which there are at most `cells`, or one. Blocks have
// `block_side` pixels on a side, at most kBlockSize.
[[nodiscard]] PilotGrid make_pilot_grid(const V2i& size_px, uint64_t cells, int block_side);

} // namespace kindling
