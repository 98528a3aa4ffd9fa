// Counts of the texture tiles that a device has loaded.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace kindling {

struct TileStatistics {
  uint64_t tiles = 0;        // of the scene; 0: all texels are in the device's memory
  uint64_t slots = 0;        // tiles that have room at a time
  uint64_t min_slots = 0;    // tiles that one surface may need at a time
  uint64_t loaded = 0;       // counted again each time
  uint64_t evicted = 0;      // likewise
  uint64_t stages_again = 0; // how often a path's stage was run again because a tile was absent
};

} // namespace kindling
