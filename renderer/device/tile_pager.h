// Pool of texture tiles in a device's memory, which are loaded when kernels ask for them.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/device/device.h"
#include "renderer/device/kernels/wave.h"
#include "renderer/device/tile_plan.h"
#include "renderer/device/tile_statistics.h"

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

namespace kindling {

// A kernel that shades runs for all paths of a launch. Those that miss a tile have had no effect,
// and wait. The pager loads the tiles that were asked for, in place of those that were not used for
// the longest time, and the kernel runs again for the paths that waited. If the pool has not the
// room for all, paths that miss the same tiles run together, few enough at a time; a path alone
// always has room, so each launch of a few brings some to the end of the stage.
class TilePager {
 public:
  // `slots`: at least plan.tiles_of_surface, or plan.tile_count() if that is less. `paths`: most
  // that run() is called for. `textures`, those that the plan was made for, must outlive this.
  TilePager(Device& device, std::span<const TextureView> textures, TilePlan plan, uint32_t slots, uint32_t paths);

  // Returns the bytes that a pager takes on a device.
  [[nodiscard]] static uint64_t bytes(const TilePlan& plan, uint32_t slots, uint32_t paths);
  // Returns the slots that have room in so many bytes, at most one for each tile; 0 if there are
  // none.
  [[nodiscard]] static uint32_t slots_within(uint64_t bytes, const TilePlan& plan, uint32_t paths);

  [[nodiscard]] const TilePlan& plan() const { return plan_; }
  // By texture: addresses on the device.
  [[nodiscard]] const TextureTiles* tiles_on_device() const { return device_textures_.data(); }

  // Launches a kernel for the numbers in [0, count) until all have had their effect. `wave` is part
  // of the kernel's argument, which `launch(count)` passes on. Ends early once abandoned() is true.
  void run(WaveTiles& wave, uint32_t count, const std::function<void(uint32_t)>& launch,
           const std::function<bool()>& abandoned);

  [[nodiscard]] const TileStatistics& statistics() const { return statistics_; }

 private:
  void begin_launch();
  // Return what the last launch has left: paths that wait, sorted by the tile that they miss, and
  // the tiles that it asked for.
  [[nodiscard]] std::vector<uint64_t> waiting();
  [[nodiscard]] std::vector<uint32_t> requests();
  // Loads tiles in place of any that the last launch did not use. False if there is no room for
  // all; `room` is set to the number of tiles that have room.
  [[nodiscard]] bool load(std::span<const uint32_t> tiles, size_t& room);
  void copy_tile(uint32_t tile, std::byte* to) const;

  Device& device_;
  std::span<const TextureView> textures_;
  TilePlan plan_;
  uint32_t slot_count_;
  uint32_t launch_ = 0;
  TileStatistics statistics_;
  std::vector<uint32_t> slots_; // by tile
  std::vector<uint32_t> tiles_; // by slot

  DeviceArray<TextureTiles> device_textures_;
  DeviceArray<TilePool> device_pool_;
  DeviceArray<uint32_t> device_slots_;
  DeviceArray<std::byte> texels_;
  DeviceArray<uint32_t> last_use_, requests_, missed_;
  DeviceArray<uint64_t> again_, waiting_;
  DeviceArray<uint32_t> waiting_count_;
};

} // namespace kindling
