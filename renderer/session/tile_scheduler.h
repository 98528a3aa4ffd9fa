// Which pixels and samples are rendered together, and in which order: pure functions, without threads.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/film/film.h"
#include "renderer/integrator/integrator.h"

#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

namespace kindling {

// Tiles of the grid with side `tile_size_px` through the image's origin, cut to the crop, in scan order. None is empty;
// together they cover each pixel of the crop once. tile_size_px: a positive multiple of kBlockSize.
[[nodiscard]] std::vector<PixelRect> make_tiles(const PixelRect& crop, int tile_size_px);

// Who renders what; the image does not depend on it.
enum class Schedule : uint8_t {
  tiles,   // handed out one by one to whoever is free
  regions, // each worker has a region of its own and nothing else: what machines without a common memory can do
};
[[nodiscard]] std::string_view schedule_name(Schedule schedule); // "tiles", "regions"
[[nodiscard]] std::optional<Schedule> schedule_from_name(std::string_view name);

// One rectangle for each of `workers` (at least 1): together they cover each pixel of the crop once. The crop is halved again and again
// across its longer side, in proportion to the workers of either half; cuts are on the grid of blocks, so areas differ by what
// that rounds. Where there are fewer blocks than workers, some rectangles are empty.
[[nodiscard]] std::vector<PixelRect> make_regions(const PixelRect& crop, int workers);

// The blocks of a tile, on the grid with side kBlockSize through the image's origin, in scan order.
[[nodiscard]] std::vector<PixelRect> make_blocks(const PixelRect& tile);

// The same one by one: how many, and the one at `index` below that.
[[nodiscard]] size_t count_blocks(const PixelRect& tile);
[[nodiscard]] PixelRect block_of(const PixelRect& tile, size_t index);

// The next pass after `done` of `total` samples: short passes first, so that an image exists early and a render can stop
// early; then longer ones, so that threads seldom wait for each other. `passes_per_second`: passes of one sample that a second
// holds, 0 if not known yet: then it is one sample. Neither changes the image.
[[nodiscard]] SampleRange next_pass(uint32_t done, uint32_t total, double passes_per_second);

} // namespace kindling
