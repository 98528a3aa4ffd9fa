// Tiles of textures in the memory of a device, of which only some are there at a time.
//
// A tile has kTileBytes: 64 texels by as many rows as fit. The coarsest levels of a texture, as
// many as fit together, share one tile. Tiles of all textures are numbered; a page table maps a
// number to a slot of a pool. A look-up that meets an absent tile requests it and reads zeros
// instead; the kernel asks afterwards whether its thread has missed any, and waits.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/gpu_thread.h"
#include "renderer/base/on_gpu.h"
#include "renderer/texture/mip_levels.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

namespace kindling {

inline constexpr uint32_t kTileBytes = 16384; // 64 x 64 texels of four bytes
inline constexpr uint32_t kTileWidth = 64;    // texels

#if !KINDLING_ON_GPU
// State of the running thread alone, set by TilePool::begin(): a GPU has an array for it.
inline thread_local uint32_t missed_tile = 0;
#endif

// The tiles that are there, and what look-ups report. Pointers are addresses in the device's
// memory.
struct TilePool {
  static constexpr uint32_t kNone = ~uint32_t{0};

  const uint32_t* slots = nullptr;   // by tile: its place in the pool, or kNone
  const std::byte* texels = nullptr; // by slot: kTileBytes each
  uint32_t* last_use = nullptr;      // by slot: the last launch that read it
  uint32_t* requests = nullptr;      // a bit for each tile
  uint32_t* missed = nullptr;        // by thread of a GPU
  uint32_t launch = 0;               // number of this one

  // Forgets what the running thread has missed.
  void begin() const { missed_here() = kNone; }
  // Returns the first absent tile that the running thread has asked for since begin(), or kNone.
  [[nodiscard]] uint32_t missing() const { return missed_here(); }

  // Returns the texels of a tile. If it is absent, requests it and returns null.
  [[nodiscard]] const std::byte* find(uint32_t tile) const {
    const uint32_t slot = slots[tile];
    if (slot != kNone) {
      // Threads write the same number, so it does not matter who is last.
      if (__atomic_load_n(last_use + slot, __ATOMIC_RELAXED) != launch)
        __atomic_store_n(last_use + slot, launch, __ATOMIC_RELAXED);
      return texels + size_t{slot} * kTileBytes;
    }
    __atomic_fetch_or(requests + tile / 32, uint32_t{1} << tile % 32, __ATOMIC_RELAXED);
    uint32_t& first = missed_here();
    if (first == kNone) first = tile;
    return nullptr;
  }

 private:
  [[nodiscard]] uint32_t& missed_here() const {
#if KINDLING_ON_GPU
    return missed[gpu_thread_number()];
#else
    return missed_tile;
#endif
  }
};

// A level of a texture in tiles.
struct TileLevel {
  uint32_t first_tile = TilePool::kNone; // kNone: all texels of the level are in memory
  uint32_t width = 0;                    // texels
  uint32_t columns = 0;                  // tiles side by side; 0: the level is a part of its tile
  uint32_t offset = 0;                   // of that part, bytes
};

// Texel of absent tiles.
inline constexpr std::array<std::byte, 16> kAbsentTexel{};

// The tiles of one texture.
struct TextureTiles {
  // Returns the address of a texel of a level in tiles, whose index is that in a level in memory;
  // zeros if its tile is absent.
  [[nodiscard]] KINDLING_CALLED_ON_GPU const std::byte* texel(int level, size_t index, uint32_t pixel_bytes) const {
    const TileLevel& from = levels[static_cast<size_t>(level)];
    uint32_t tile = from.first_tile, place = static_cast<uint32_t>(index);
    if (from.columns > 0) {
      const uint32_t row = place / from.width, column = place % from.width;
      tile += row / rows * from.columns + column / kTileWidth;
      place = row % rows * kTileWidth + column % kTileWidth;
    }
    const std::byte* const texels = pool->find(tile);
    return texels != nullptr ? texels + from.offset + place * pixel_bytes : kAbsentTexel.data();
  }
  // Copies the texels (x[0], y[0]), (x[1], y[0]), (x[0], y[1]), (x[1], y[1]) of a level in tiles.
  void fetch(int level, const std::array<int, 2>& x, const std::array<int, 2>& y, uint32_t pixel_bytes,
             std::byte* copies) const {
    const size_t width = levels[static_cast<size_t>(level)].width;
    for (size_t i = 0; i < 4; ++i)
      copies =
          std::copy_n(texel(level, static_cast<size_t>(y[i / 2]) * width + static_cast<size_t>(x[i % 2]), pixel_bytes),
                      pixel_bytes, copies);
  }

  const TilePool* pool = nullptr;
  uint32_t rows = 0; // of a tile, texels
  std::array<TileLevel, kMaxMipLevels> levels;
};

// Returns the height of tiles of such texels.
[[nodiscard]] constexpr uint32_t tile_rows(uint32_t pixel_bytes) { return kTileBytes / (kTileWidth * pixel_bytes); }

} // namespace kindling
