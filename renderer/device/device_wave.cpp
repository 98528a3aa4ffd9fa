// Plans a wave, and brings its sums to the film.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/device/device_wave.h"

#include <algorithm>
#include <array>
#include <cassert>

namespace kindling {

DeviceWave::DeviceWave(Device& device, const World& world, bool with_surfaces)
    : device_(device), world_(world), capacity_(device.wave_size()), samples_(device, capacity_),
      surfaces_(device, with_surfaces ? capacity_ : 0), rays_(device, capacity_), losses_(device, 1) {
  assert(capacity_ >= kBlockSize * kBlockSize);
}

uint32_t DeviceWave::take(size_t number, const PixelRect& block, const SampleRange& samples) {
  const auto pixels = static_cast<uint32_t>(block.pixel_count());
  const uint32_t count = std::min(samples.count(), (capacity_ - sample_count_) / pixels);
  if (count == 0) return 0;
  blocks_.push_back({.corner = block.min,
                     .width = static_cast<uint32_t>(block.width()),
                     .height = static_cast<uint32_t>(block.height()),
                     .first_index = samples.first,
                     .samples = count,
                     .first_sample = sample_count_,
                     .first_pixel = pixel_count_});
  numbers_.push_back(number);
  sample_count_ += pixels * count;
  pixel_count_ += pixels;
  return count;
}

void DeviceWave::start(const Film& film, Wave& wave) {
  if (device_blocks_.size() < blocks_.size()) device_blocks_ = DeviceArray<WaveBlock>(device_, blocks_.size());
  device_blocks_.upload(blocks_);
  losses_.upload(std::array{WaveLosses{}});
  const AovSet aovs = film.aovs();
  wave.blocks = device_blocks_.span().first(blocks_.size());
  wave.samples = samples_.data();
  wave.surfaces = surfaces_.data();
  wave.rays = rays_.data();
  wave.film = {.sums = sums_.start(device_, pixel_count_),
               .moments = moments_.start(device_, aovs.contains(Aov::variance) ? pixel_count_ : 0),
               .surfaces = surface_sums_.start(device_, aovs.needs_surface() ? pixel_count_ : 0),
               .guides = guides_.start(device_, aovs.needs_guides() ? pixel_count_ : 0),
               .components = components_.start(device_, aovs.needs_components() ? pixel_count_ : 0),
               .blocks = outlier_blocks_.start(
                   device_, film.trims_outliers() ? size_t{pixel_count_} * (kOutlierBlocks - 1) : 0)};
  wave.block_rays = block_rays_.start(device_, blocks_.size()).data();
  wave.losses = losses_.data();
}

void DeviceWave::download_sums() {
  sums_.download();
  moments_.download();
  surface_sums_.download();
  guides_.download();
  components_.download();
  outlier_blocks_.download();
  block_rays_.download();
}

void DeviceWave::take_results(std::span<BlockWork> work, Film& film) {
  for (size_t i = 0; i < blocks_.size(); ++i) {
    const WaveBlock& block = blocks_[i];
    BlockWork& done = work[numbers_[i]];
    const size_t pixels = size_t{block.width} * block.height;
    const auto part = [&](auto& sums, size_t per_pixel) {
      return sums.here.empty() ? std::span(sums.here)
                               : std::span(sums.here).subspan(block.first_pixel * per_pixel, pixels * per_pixel);
    };
    film.add(done.block, FilmView{part(sums_, 1), part(moments_, 1), part(surface_sums_, 1), part(guides_, 1),
                                  part(components_, 1), part(outlier_blocks_, kOutlierBlocks - 1)});
    const WaveRays<uint64_t>& rays = block_rays_.here[i];
    const uint64_t samples = pixels * block.samples;
    done.added += block.samples;
    done.rays += samples + rays.bounces + rays.shadows;
    counters.paths += samples;
    counters.camera += samples;
    counters.bounce += rays.bounces;
    counters.shadow += rays.shadows;
    counters.whitted.reflection += rays.reflections;
    counters.whitted.transmission += rays.refractions;
  }
  std::array<WaveLosses, 1> losses;
  losses_.download(losses);
  if (losses[0].count > 0) {
    const uint64_t first = losses[0].first;
    RayCounters lost;
    lost.non_finite = losses[0].count;
    lost.first_non_finite = {V2i(static_cast<int>(first & 0xffffU), static_cast<int>(first >> 16 & 0xffffU)),
                             static_cast<uint32_t>(first >> 32)};
    counters.add(lost);
  }
  blocks_.clear();
  numbers_.clear();
  sample_count_ = pixel_count_ = 0;
}

} // namespace kindling
