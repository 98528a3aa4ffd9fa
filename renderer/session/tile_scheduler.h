// Which pixels and samples are rendered together, and in which order: pure functions, without threads.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/film/film.h"
#include "renderer/integrator/integrator.h"

#include <cstdint>
#include <vector>

namespace kindling {

// Tiles of the grid with side `tile_size_px` through the image's origin, cut to the crop, in scan order. None is empty;
// together they cover each pixel of the crop once. tile_size_px: a positive multiple of kBlockSize.
[[nodiscard]] std::vector<PixelRect> make_tiles(const PixelRect& crop, int tile_size_px);

// The blocks of a tile, on the grid with side kBlockSize through the image's origin, in scan order.
[[nodiscard]] std::vector<PixelRect> make_blocks(const PixelRect& tile);

// The next pass after `done` of `total` samples: short passes first, so that a picture exists early and a render can stop
// early; then longer ones, so that threads seldom wait for each other. `passes_per_second`: passes of one sample that a second
// holds, 0 if not known yet. Neither changes the image.
[[nodiscard]] SampleRange next_pass(uint32_t done, uint32_t total, double passes_per_second);

} // namespace kindling
