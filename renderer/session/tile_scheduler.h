// Divides images into tiles, regions and blocks, and samples into passes: pure functions.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/film/film.h"
#include "renderer/integrator/integrator.h"

#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

namespace kindling {

// Returns the tiles of the grid with side `tile_size_px` through the image's origin, cut to the
// crop, in scan order. None is empty; together they cover each pixel of the crop once.
// tile_size_px: a positive multiple of kBlockSize.
[[nodiscard]] std::vector<PixelRect> make_tiles(const PixelRect& crop, int tile_size_px);

// The distribution of tiles to threads; does not change the image.
enum class Schedule : uint8_t {
  tiles,   // handed out one by one to free threads
  regions, // each thread renders one region of its own, as machines without shared memory would
};
[[nodiscard]] std::string_view schedule_name(Schedule schedule); // "tiles", "regions"
[[nodiscard]] std::optional<Schedule> schedule_from_name(std::string_view name);

// Returns one rectangle for each of `workers` (at least 1); together they cover each pixel of the
// crop once. The crop is divided recursively across its longer side, in proportion to the workers
// of either half. Cuts are rounded to the grid of blocks. If there are fewer blocks than workers,
// some rectangles are empty.
[[nodiscard]] std::vector<PixelRect> make_regions(const PixelRect& crop, int workers);

// Returns the blocks of a tile, on the grid with side kBlockSize through the image's origin, in
// scan order.
[[nodiscard]] std::vector<PixelRect> make_blocks(const PixelRect& tile);

// The number of blocks of make_blocks(), and the block at `index`.
[[nodiscard]] size_t count_blocks(const PixelRect& tile);
[[nodiscard]] PixelRect block_of(const PixelRect& tile, size_t index);

// Returns the next pass after `done` of `total` samples: short passes first, so that an image
// exists early and a render can stop early, then longer ones with less overhead.
// `passes_per_second`: passes of one sample per second; 0 if not yet known, which gives a pass of
// one sample. Passes do not change the image.
[[nodiscard]] SampleRange next_pass(uint32_t done, uint32_t total, double passes_per_second);

} // namespace kindling
