// Places the blocks of pilots.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/integrator/pilots/pilot_grid.h"

#include "renderer/base/hash.h"

#include <algorithm>

namespace kindling {

PilotGrid make_pilot_grid(const V2i& size_px, uint64_t cells, int block_side) {
  PilotGrid grid;
  int rows = 0;
  do {
    grid.side += block_side;
    const auto across = [&](int pixels) { return (pixels + grid.side - 1) / grid.side; };
    grid.columns = across(size_px.x);
    rows = across(size_px.y);
  } while (static_cast<uint64_t>(grid.columns) * static_cast<uint64_t>(rows) > std::max<uint64_t>(cells, 1));
  grid.blocks.resize(static_cast<size_t>(grid.columns) * static_cast<size_t>(rows));
  for (uint32_t cell = 0; cell < grid.blocks.size(); ++cell) {
    const V2i first(static_cast<int>(cell) % grid.columns * grid.side,
                    static_cast<int>(cell) / grid.columns * grid.side);
    V2i at;
    for (int axis = 0; axis < 2; ++axis) {
      const int places = (std::min(grid.side, size_px[axis] - first[axis]) + block_side - 1) / block_side;
      const uint32_t random = hash_combine(hash_u32(0x51edU + static_cast<uint32_t>(axis)), cell);
      at[axis] = first[axis] + static_cast<int>(random % static_cast<uint32_t>(places)) * block_side;
    }
    grid.blocks[cell] = {at, V2i(std::min(at.x + block_side, size_px.x), std::min(at.y + block_side, size_px.y))};
  }
  return grid;
}

} // namespace kindling
