// Steps that the kernels of all tracers share: places in a wave, camera rays and film samples.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/device/kernels/wave.h"
#include "renderer/integrator/stages/camera_ray.h"

#include <cstdint>

namespace kindling::kernels {

// Returns the index of the block in which `number` lies, a sample, a pixel or a light path by
// kFirst.
template <auto kFirst, typename Number>
[[nodiscard]] inline uint32_t block_of(const Wave& wave, Number number) {
  uint32_t first = 0, last = static_cast<uint32_t>(wave.blocks.size());
  while (last - first > 1) {
    const uint32_t middle = (first + last) / 2;
    (wave.blocks[middle].*kFirst <= number ? first : last) = middle;
  }
  return first;
}

// Returns the samples of pixel `within` of a block, counted row by row.
[[nodiscard]] inline WavePixel pixel_of(const Wave& wave, const WaveBlock& block, uint32_t within) {
  if (block.samples == 0) return wave.pixels[block.first_pixel + within];
  return {block.first_index, block.first_sample + within * block.samples, block.samples};
}

// Returns which pixel of the block has sample `slot`.
[[nodiscard]] inline uint32_t pixel_with(const Wave& wave, const WaveBlock& block, uint32_t slot) {
  if (block.samples > 0) return (slot - block.first_sample) / block.samples;
  uint32_t first = 0, last = block.width * block.height; // the last of the pixels that begin here or before has samples
  while (last - first > 1) {
    const uint32_t middle = (first + last) / 2;
    (wave.pixels[block.first_pixel + middle].first_sample <= slot ? first : last) = middle;
  }
  return first;
}

// Starts sample `slot`; returns its camera ray.
[[nodiscard]] inline accel::Ray begin_sample(const Wave& wave, uint32_t slot) {
  const DeviceScene& scene = *wave.scene;
  const WaveBlock& block = wave.blocks[block_of<&WaveBlock::first_sample>(wave, slot)];
  const uint32_t pixel = pixel_with(wave, block, slot);
  const WavePixel own = pixel_of(wave, block, pixel);
  CameraSample sample;
  sample.pixel = block.corner + V2i(static_cast<int>(pixel % block.width), static_cast<int>(pixel / block.width));
  sample.sample_index = own.first_index + (slot - own.first_sample);
  sample.address = scene.sampler.address(sample.pixel, sample.sample_index);
  const accel::Ray ray = make_camera_ray(scene.camera, scene.filter, draw_camera(scene.camera, sample.address),
                                         sample.pixel, sample.address, sample.filter_weight);
  wave.samples[slot] = sample;
  wave.rays[slot] = {};
  if (wave.surfaces != nullptr) wave.surfaces[slot] = FilmSurface{};
  if (wave.first_hits != nullptr) wave.first_hits[slot] = WaveFirstHit{};
  return ray;
}

// Returns the number that this run of a kernel is for: `number` in a first launch.
[[nodiscard]] inline uint32_t number_of(const WaveTiles& tiles, uint32_t number) {
  return tiles.again != nullptr ? static_cast<uint32_t>(tiles.again[number]) : number;
}
// Called before the look-ups of a kernel.
inline void begin_look_ups(const WaveTiles& tiles) {
  if (tiles.pool != nullptr) tiles.pool->begin();
}
// True if one of the look-ups since has missed a tile. Then the kernel has no effect, and will run
// for `number` again.
[[nodiscard]] inline bool waits_for_tiles(const WaveTiles& tiles, uint32_t number) {
  if (tiles.pool == nullptr) return false;
  const uint32_t missing = tiles.pool->missing();
  if (missing == TilePool::kNone) return false;
  tiles.waiting[__atomic_fetch_add(tiles.waiting_count, 1U, __ATOMIC_RELAXED)] = uint64_t{missing} << 32 | number;
  return true;
}

inline void add_loss(WaveLosses& losses, const CameraSample& sample) {
  const uint64_t here = uint64_t{sample.sample_index} << 32 | static_cast<uint64_t>(sample.pixel.y) << 16 |
                        static_cast<uint64_t>(sample.pixel.x);
  __atomic_fetch_add(&losses.count, uint64_t{1}, __ATOMIC_RELAXED);
  uint64_t first = __atomic_load_n(&losses.first, __ATOMIC_RELAXED);
  while (here < first &&
         !__atomic_compare_exchange_n(&losses.first, &first, here, false, __ATOMIC_RELAXED, __ATOMIC_RELAXED)) {
  }
}

// A sample that is finished.
struct FinishedSample {
  Rgb radiance;
  float alpha = 1.0f;
  Rgb emission{0.0f}, direct{0.0f}; // for AOVs
};

struct AddNothing {
  void operator()(uint32_t /*slot*/, const FilmSample& /*sample*/) const {}
};

// Adds the samples of a pixel to its sums. `finished(slot)` returns a FinishedSample;
// `add_more(slot, FilmSample)` adds what else the film has of it.
template <typename Finished, typename AddMore = AddNothing>
inline void add_pixel(const Wave& wave, uint32_t pixel, const Finished& finished, const AddMore& add_more = {}) {
  const uint32_t number = block_of<&WaveBlock::first_pixel>(wave, pixel);
  const WaveBlock& block = wave.blocks[number];
  const WavePixel own = pixel_of(wave, block, pixel - block.first_pixel);
  WaveRays<uint64_t> rays;
  for (uint32_t slot = own.first_sample; slot < own.first_sample + own.samples; ++slot) {
    const CameraSample& sample = wave.samples[slot];
    rays.bounces += wave.rays[slot].bounces;
    rays.shadows += wave.rays[slot].shadows;
    rays.reflections += wave.rays[slot].reflections;
    rays.refractions += wave.rays[slot].refractions;
    const FinishedSample done = finished(slot);
    if (!is_finite(done.radiance)) {
      add_loss(*wave.losses, sample);
      if (wave.first_hits != nullptr) wave.first_hits[slot].lost = true;
      continue;
    }
    const FilmSample of_film{done.radiance, done.alpha, sample.filter_weight, sample.sample_index};
    wave.film.add(pixel, of_film);
    add_more(slot, of_film);
    if (wave.surfaces == nullptr) continue;
    FilmSurface& surface = wave.surfaces[slot];
    surface.emission = done.emission;
    surface.direct = done.direct;
    wave.film.add_surface(pixel, surface, sample.filter_weight);
  }
  WaveRays<uint64_t>& sum = wave.block_rays[number];
  __atomic_fetch_add(&sum.bounces, rays.bounces, __ATOMIC_RELAXED);
  __atomic_fetch_add(&sum.shadows, rays.shadows, __ATOMIC_RELAXED);
  __atomic_fetch_add(&sum.reflections, rays.reflections, __ATOMIC_RELAXED);
  __atomic_fetch_add(&sum.refractions, rays.refractions, __ATOMIC_RELAXED);
}

} // namespace kindling::kernels
