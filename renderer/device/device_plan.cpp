// Finds the largest waves and pools that a device has room for.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/device/device_plan.h"

#include "renderer/device/mebibytes.h"

#include <algorithm>
#include <string>
#include <utility>

namespace kindling {
namespace {

// Allocations are aligned; a wave has fewer than these.
constexpr uint64_t kAlignments = 64 * 256;

std::string refusal(const Device& device, uint64_t free, uint64_t scene, uint64_t photons, uint64_t waves,
                    uint64_t tiles) {
  std::string parts = "scene " + mebibytes(scene) + ", waves " + mebibytes(waves);
  if (photons > 0) parts += ", photons " + mebibytes(photons);
  if (tiles > 0) parts += ", texture tiles " + mebibytes(tiles);
  return device.name() + ": no room for the scene: it needs at least " + mebibytes(scene + photons + waves + tiles) +
         " (" + parts + "), and " + mebibytes(free) + " are free; use --device cpu";
}

} // namespace

DevicePlan plan_device_memory(const Device& device, const DeviceSceneInput& input,
                              const std::function<uint64_t(uint32_t)>& wave_bytes, const PhotonMapNeeds& photons) {
  const uint64_t free = device.free_bytes();
  const auto waves = [&](uint32_t paths) { return wave_bytes(paths) + kAlignments; };
  const uint64_t scene = scene_on_device_bytes(input, nullptr), whole = scene + photons.bytes;
  const uint32_t max_paths = device.wave_size();
  if (scene + photons.together * photons.bytes + waves(max_paths) <= free)
    return {.paths = max_paths, .photon_maps = photons.together};
  for (uint32_t paths = max_paths; paths >= std::max(max_paths / 16, kMinWaveSize); paths /= 2)
    if (whole + waves(paths) <= free) return {.paths = paths};
  const uint32_t fewest = std::min(max_paths, kMinWaveSize);
  TilePlan tiles = plan_tiles(input.world);
  if (tiles.tile_count() == 0) {
    for (uint32_t paths = max_paths; paths >= fewest; paths /= 2)
      if (whole + waves(paths) <= free) return {.paths = paths};
    throw DeviceError(refusal(device, free, scene, photons.bytes, waves(fewest), 0));
  }
  const uint64_t untextured = scene_on_device_bytes(input, &tiles), rest = untextured + photons.bytes;
  const uint32_t min_slots = std::min(tiles.tiles_of_surface, tiles.tile_count());
  uint32_t paths = max_paths;
  const uint64_t room = free > rest ? free - rest : 0;
  while (paths > fewest && waves(paths) + TilePager::bytes(tiles, 0, paths) > room / 4) paths /= 2;
  const uint64_t for_tiles = room > waves(paths) ? room - waves(paths) : 0;
  const uint32_t slots = TilePager::slots_within(for_tiles, tiles, paths);
  if (slots < min_slots)
    throw DeviceError(
        refusal(device, free, untextured, photons.bytes, waves(fewest), TilePager::bytes(tiles, min_slots, fewest)));
  return {.paths = paths, .tiles = std::move(tiles), .slots = slots};
}

} // namespace kindling
