// The kernels that share paths between pixels (reuse_paths.h), once all paths of a wave have ended.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/kdtree/compact/queries.h"
#include "renderer/device/kernels/path_wave.h"
#include "renderer/device/kernels/wave_kernels.h"

#include <bit>
#include <cstdint>

namespace kindling::kernels {

// Returns the group of a path: the same sample of other pixels of its block, which is whole.
[[nodiscard]] inline ReuseGroup group_of(const PathWave& wave, uint32_t slot) {
  const WaveBlock& block = wave.blocks[block_of<&WaveBlock::first_sample>(wave, slot)];
  const uint32_t pixel = pixel_with(wave, block, slot);
  const uint32_t sample = slot - block.first_sample - pixel * block.samples;
  const uint32_t pattern = reuse_pattern(block.corner, block.first_index + sample);
  ReuseGroup group;
  for (uint32_t place = 0; place < wave.reuse.count; ++place) {
    const uint32_t partner = reuse_partner(pixel / block.width * kReuseSide + pixel % block.width, pattern, place);
    const uint32_t x = partner % kReuseSide, y = partner / kReuseSide;
    group[place] = x < block.width && y < block.height
                       ? block.first_sample + (y * block.width + x) * block.samples + sample
                       : kNoPath;
  }
  return group;
}

// By path.
inline void start_sharing(const PathWave& wave, uint32_t slot) { wave.reuse.start_sharing(slot, wave.states[slot]); }

// Appends the links to the first surface of a path whose rays are to be traced.
inline void link_paths(const PathWave& wave, uint32_t slot) {
  const uint32_t traced = wave.reuse.link_paths(wave.scene->stages, slot, group_of(wave, slot));
  if (traced == 0) return;
  const auto count = static_cast<uint32_t>(std::popcount(traced));
  uint32_t next = wave.reuse_links.take_places(count);
  for (uint32_t place = 1; traced >> place != 0; ++place)
    if ((traced >> place & 1U) != 0) wave.reuse_links.paths[next++] = slot * wave.reuse.count + place;
  wave.rays[slot].shadows += count;
}

template <typename Blocked>
[[gnu::always_inline]] inline void trace_link_of(const PathWave& wave, uint32_t number, const Blocked& blocked) {
  const uint32_t link = wave.reuse_links.paths[number];
  const uint32_t slot = link / wave.reuse.count, place = link % wave.reuse.count;
  if (blocked(wave.reuse.link_ray(slot, group_of(wave, slot), place, wave.samples[slot]))) wave.reuse.links[link] = {};
}

// By link of the queue: clears it if something is in between.
inline void trace_link(const PathWave& wave, uint32_t number) {
  trace_link_of(wave, number, [&](const accel::Ray& ray) { return wave.scene->world.probe_is_blocked(ray); });
}
// The same where WorldView::filters_hits is false.
inline void trace_link_opaque(const PathWave& wave, uint32_t number) {
  trace_link_of(
      wave, number, [&](const accel::Ray& ray) __attribute__((always_inline)) {
        return accel::kd::compact::occluded(wave.scene->tree, ray, accel::kd::compact::AcceptAll{});
      });
}

// By path: what is received from its second surface, then what its first surface receives.
inline void share_light(const PathWave& wave, uint32_t slot) { wave.reuse.share_light(slot, group_of(wave, slot)); }
inline void receive_light(const PathWave& wave, uint32_t slot) {
  wave.reuse.receive(slot, group_of(wave, slot), wave.states[slot]);
}

} // namespace kindling::kernels
