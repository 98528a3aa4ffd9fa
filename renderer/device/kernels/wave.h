// The memory of a wave: samples that a device follows together, from the camera to the film.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/ray.h"
#include "renderer/device/kernels/device_scene.h"
#include "renderer/film/film_view.h"
#include "renderer/integrator/stages/camera_sample.h"
#include "renderer/texture/texture_tiles.h"

#include <cstdint>
#include <span>

namespace kindling {

// Samples of the pixels of one block. Samples and pixels are consecutive in the wave: all samples
// of a pixel, then those of the next pixel, row by row. If there are sample rates, WavePixel has
// the samples of each pixel.
struct WaveBlock {
  V2i corner{0}; // the upper left pixel
  uint32_t width = 0, height = 0;
  uint32_t first_index = 0; // of the samples in their pixel
  uint32_t samples = 0;     // of each pixel; 0: see Wave::pixels
  uint32_t first_sample = 0;
  uint32_t first_pixel = 0;
  // Its light paths: all pixels of a pass, row by row, and its share of those outside of the crop
  // (OutsidePixels), then those of the next pass.
  uint64_t first_light_path = 0;
  uint64_t first_outside = 0, outside = 0; // number of the first pixel outside, and how many there are
  uint32_t first_pass = 0;
};

// Samples of one pixel of a wave.
struct WavePixel {
  uint32_t first_index = 0; // of the samples in their pixel
  uint32_t first_sample = 0;
  uint32_t samples = 0;
};

// Counts of rays, of a sample or of a block. Reflections and refractions are among the bounces, and
// counted by the Whitted tracer alone.
template <typename Count>
struct WaveRays {
  Count bounces = 0, shadows = 0, reflections = 0, refractions = 0;
};

// The first surface of a sample, for what films record of it beside its light (FirstHits).
struct WaveFirstHit {
  accel::Hit hit;    // no hit: it has none
  bool lost = false; // its radiance was not finite
};

// Samples of a wave that were dropped because their radiance was not finite.
struct WaveLosses {
  static constexpr uint64_t kNone = ~uint64_t{0};

  uint64_t count = 0;
  uint64_t first = kNone; // the least of them, by index, row and column: 32, 16 and 16 bits
};

// Queue of a kernel that shades, where textures are in tiles (TilePager).
struct WaveTiles {
  const TilePool* pool = nullptr;  // null: all texels are in memory
  const uint64_t* again = nullptr; // numbers that run again, in the lower 32 bits; null: all
  // Receives the numbers that wait, with the first tile that each misses in the upper bits.
  uint64_t* waiting = nullptr;
  uint32_t* waiting_count = nullptr;
};

// The part of a wave that all tracers have.
struct Wave {
  const DeviceScene* scene = nullptr;
  std::span<const WaveBlock> blocks;
  std::span<const WavePixel> pixels; // empty: all pixels of a block have the same samples
  CameraSample* samples = nullptr;
  FilmSurface* surfaces = nullptr;    // by sample; null if no AOV needs it
  WaveFirstHit* first_hits = nullptr; // likewise
  WaveRays<uint32_t>* rays = nullptr;
  FilmView film;                            // by pixel
  WaveRays<uint64_t>* block_rays = nullptr; // one more than there are blocks, for light paths of pixels outside
  WaveLosses* losses = nullptr;
  WaveTiles tiles;
};

} // namespace kindling
