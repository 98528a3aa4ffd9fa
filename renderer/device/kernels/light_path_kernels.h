// The kernels of light paths, each for one path or one of its joints with the camera.
//
// A path writes to its own slot alone, and the light that it brings is added to the film's exact
// sums, so its place in queues and lists does not matter. Photons are sorted after they have come
// back.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/kdtree/compact/queries.h"
#include "renderer/device/kernels/path_wave.h"
#include "renderer/device/kernels/wave_kernels.h"
#include "renderer/integrator/stages/light_path_stages.h"

#include <cstdint>
#include <optional>

namespace kindling::kernels {

// Starts a light path of this round, if it carries light. intersect() and intersect_opaque() find
// its hits.
inline void begin_light_path(const PathWave& wave, uint32_t slot) {
  const LightPathStages& stages = wave.scene->light_paths;
  const uint64_t number = wave.first_light_path + slot;
  WaveLightPath& path = wave.light_paths[slot];
  path.block = block_of<&WaveBlock::first_light_path>(wave, number);
  const WaveBlock& block = wave.blocks[path.block];
  const uint64_t within = number - block.first_light_path, pixels = uint64_t{block.width} * block.height;
  const uint64_t of_pass = pixels + block.outside;
  const uint32_t pass = block.first_pass + static_cast<uint32_t>(within / of_pass);
  const uint64_t pixel = within % of_pass;
  uint64_t path_number = 0;
  if (pixel < pixels) {
    const auto at = static_cast<uint32_t>(pixel);
    path_number = stages.number_of(
        block.corner + V2i(static_cast<int>(at % block.width), static_cast<int>(at / block.width)), pass);
  } else {
    path.block = static_cast<uint32_t>(wave.blocks.size());
    path_number = stages.number_at(stages.outside.index_at(block.first_outside + (pixel - pixels)), pass);
  }
  if (stages.start(path_number, path.state, wave.path_rays[slot])) wave.next.append(slot);
}

// Moves an active light path on from its hit, and joins it to the camera there.
template <bool kSplits>
inline void move_light_path(const PathWave& wave, uint32_t launched) {
  const uint32_t number = number_of(wave.tiles, launched);
  const DeviceScene& scene = *wave.scene;
  const uint32_t slot = wave.active.paths[number];
  const accel::Hit hit = wave.hits[slot];
  accel::Ray ray = wave.path_rays[slot];
  WaveLightPath& path = wave.light_paths[slot];
  std::optional<LightJoint> joint;
  SplatParts parts;
  bool continues = false;
  if (hit.is_hit()) {
    SurfacePoint surface;
    const accel::Ray arrived = ray;
    begin_look_ups(wave.tiles);
    scene.world.surface_at(ray, hit, surface);
    if (waits_for_tiles(wave.tiles, number)) return;
    continues = scene.light_paths.scatter(scene.stages, hit, surface, ray, path.state, joint);
    if constexpr (kSplits)
      if (joint)
        parts = scene.light_paths.parts_of(scene.stages, scene.groups, surface, hit, arrived, path.state, *joint);
  }
  if (continues) {
    wave.path_rays[slot] = ray;
    wave.next.append(slot);
  }
  WaveRays<uint64_t>& rays = wave.block_rays[path.block];
  __atomic_fetch_add(&rays.bounces, uint64_t{1}, __ATOMIC_RELAXED);
  if (!joint) return;
  __atomic_fetch_add(&rays.shadows, uint64_t{1}, __ATOMIC_RELAXED);
  const uint32_t place = wave.shadows.take_places(1);
  wave.shadow_rays[place] = joint->sight;
  wave.splats[place] = {joint->film_px, joint->radiance};
  if constexpr (kSplits) wave.splat_parts[place] = parts;
}

inline void scatter_light_path(const PathWave& wave, uint32_t number) { move_light_path<false>(wave, number); }
// The same where light is split by light group and first event.
inline void scatter_split_light_path(const PathWave& wave, uint32_t number) { move_light_path<true>(wave, number); }

// Starts a light path of this round that leaves photons, if it carries light.
inline void begin_photon_path(const PathWave& wave, uint32_t slot) {
  const LightPathStages& stages = wave.scene->light_paths;
  const uint64_t number = LightPathStages::kFirstPhotonPath + wave.first_light_path + slot;
  if (stages.start(number, wave.light_paths[slot].state, wave.path_rays[slot])) wave.next.append(slot);
}

// Moves an active light path that leaves photons on from its hit.
inline void leave_photon(const PathWave& wave, uint32_t launched) {
  const uint32_t number = number_of(wave.tiles, launched);
  const DeviceScene& scene = *wave.scene;
  const uint32_t slot = wave.active.paths[number];
  const accel::Hit hit = wave.hits[slot];
  if (!hit.is_hit()) return;
  accel::Ray ray = wave.path_rays[slot];
  SurfacePoint surface;
  begin_look_ups(wave.tiles);
  scene.world.surface_at(ray, hit, surface);
  if (waits_for_tiles(wave.tiles, number)) return;
  std::optional<Photon> photon;
  if (scene.light_paths.scatter_photon(scene.stages, scene.groups, hit, surface, ray, wave.light_paths[slot].state,
                                       photon)) {
    wave.path_rays[slot] = ray;
    wave.next.append(slot);
  }
  if (photon) wave.left_photons[wave.photons_left.take_places(1)] = {*photon, slot};
}

// Takes away what the camera does not see.
inline void trace_sight(const PathWave& wave, uint32_t number) {
  if (wave.scene->world.probe_is_blocked(wave.shadow_rays[number])) wave.splats[number].radiance = Rgb(0.0f);
}

// The same where WorldView::filters_hits is false.
inline void trace_sight_opaque(const PathWave& wave, uint32_t number) {
  if (accel::kd::compact::occluded(wave.scene->tree, wave.shadow_rays[number], accel::kd::compact::AcceptAll{}))
    wave.splats[number].radiance = Rgb(0.0f);
}

} // namespace kindling::kernels
