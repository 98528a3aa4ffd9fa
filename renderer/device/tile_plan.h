// The texels of a scene that may be paged on a device, and their tiles.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/texture/texture_tiles.h"
#include "renderer/world/world_view.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace kindling {

// Levels that rays and light samples read on their way stay in memory: level 0 of textures that
// decide coverage, of thin walls and of sampled emission, and all levels of images that procedural
// textures read. All other levels are read by WorldView::surface_at() for the surface that a path
// has reached, so the path can wait there.
struct TilePlan {
  // The first texel of a tile. A tile of several levels begins with the finest of them.
  struct Source {
    uint32_t texture = 0;
    uint16_t level = 0;
    bool several_levels = false;
    int x = 0, y = 0;
  };

  std::vector<TextureTiles> textures; // by texture of the world; without a pool
  std::vector<Source> sources;        // by tile
  uint32_t tiles_of_surface = 1;      // that one surface may read, at most

  [[nodiscard]] uint32_t tile_count() const { return static_cast<uint32_t>(sources.size()); }
  [[nodiscard]] bool in_tiles(size_t texture, int level) const {
    return textures[texture].levels[static_cast<size_t>(level)].first_tile != TilePool::kNone;
  }
};

// Levels with the same texels have the same tiles.
[[nodiscard]] TilePlan plan_tiles(const WorldView& world);

} // namespace kindling
