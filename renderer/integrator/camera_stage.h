// Camera rays of a batch, the first stage of every integrator.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/integrator/integrator.h"
#include "renderer/integrator/stages/camera_ray.h"
#include "renderer/sampling/draw_eight.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cstdint>
#include <span>

namespace kindling {

// Makes the rays of up to eight camera samples and sets their weights; all else of the samples is
// set.
inline void make_camera_rays(const Camera& camera, const PixelFilter& filter, std::span<CameraSample> samples,
                             std::span<accel::Ray> rays) {
  assert(!samples.empty() && samples.size() <= 8 && rays.size() == samples.size());
  std::array<SampleAddress, 8> addresses;
  for (size_t i = 0; i < addresses.size(); ++i) addresses[i] = samples[std::min(i, samples.size() - 1)].address;
  CameraDrawsOf<Lanes> draws{.filter = draw_eight(addresses, kFilterDimension)};
  if (camera.has_lens()) draws.lens = draw_eight(addresses, kLensDimension);
  if (camera.shutter_open()) draws.time = draw_eight(addresses, kTimeDimension).x;
  make_camera_rays(camera, filter, draws, samples, rays);
}

// The points of the pixels of a block, row by row.
using BlockPoints = std::array<Sampler::PixelPoints, kBlockSize * kBlockSize>;
[[nodiscard]] inline BlockPoints points_of(const PixelRect& block, const Sampler& sampler) {
  assert(!block.empty() && block.width() <= kBlockSize && block.height() <= kBlockSize);
  BlockPoints points;
  size_t pixel = 0;
  for (int y = block.min.y; y < block.max.y; ++y)
    for (int x = block.min.x; x < block.max.x; ++x) points[pixel++] = sampler.points_of(V2i(x, y));
  return points;
}

// Generates the camera rays of a batch: `samples` of every pixel of the block, sample by sample,
// pixels row by row. Fills samples.count() * pixels camera samples and rays.
inline void generate_camera_rays(const Camera& camera, const Sampler& sampler, const PixelFilter& filter,
                                 const PixelRect& block, const SampleRange& samples,
                                 std::span<CameraSample> camera_samples, std::span<accel::Ray> rays) {
  assert(camera_samples.size() >= static_cast<size_t>(block.pixel_count()) * samples.count());
  assert(rays.size() >= static_cast<size_t>(block.pixel_count()) * samples.count());
  const BlockPoints points = points_of(block, sampler);
  const auto width = static_cast<size_t>(block.width());
  size_t slot = 0;
  for (uint32_t s = samples.first; s < samples.end; ++s) {
    size_t pixel = 0;
    for (int y = block.min.y; y < block.max.y; ++y) {
      for (size_t i = 0; i < width; ++i)
        camera_samples[slot + i] = {sampler.address_in(points[pixel++], s), s,
                                    V2i(block.min.x + static_cast<int>(i), y)};
      make_camera_rays(camera, filter, camera_samples.subspan(slot, width), rays.subspan(slot, width));
      slot += width;
    }
  }
}

// Sample `number` of a pixel of a block.
struct BlockSample {
  uint8_t x = 0; // from the block's corner
  uint8_t y = 0;
  uint32_t number = 0;
};

// The same for the samples of a list.
inline void generate_camera_rays(const Camera& camera, const Sampler& sampler, const PixelFilter& filter,
                                 const PixelRect& block, std::span<const BlockSample> list,
                                 std::span<CameraSample> camera_samples, std::span<accel::Ray> rays) {
  assert(camera_samples.size() >= list.size() && rays.size() >= list.size());
  const BlockPoints points = points_of(block, sampler);
  for (size_t slot = 0; slot < list.size(); ++slot) {
    const BlockSample& sample = list[slot];
    const size_t pixel = static_cast<size_t>(sample.y) * static_cast<size_t>(block.width()) + sample.x;
    camera_samples[slot] = {sampler.address_in(points[pixel], sample.number), sample.number,
                            block.min + V2i(sample.x, sample.y)};
  }
  for (size_t slot = 0; slot < list.size(); slot += 8) {
    const size_t count = std::min(list.size() - slot, size_t{8});
    make_camera_rays(camera, filter, camera_samples.subspan(slot, count), rays.subspan(slot, count));
  }
}

// Returns how many samples of each pixel of the block fit into a batch of `batch_size` paths; at
// least 1.
[[nodiscard]] inline uint32_t samples_per_batch(const PixelRect& block, uint32_t batch_size) {
  assert(!block.empty());
  return std::max(1U, batch_size / static_cast<uint32_t>(block.pixel_count()));
}

// Returns the block of the image's grid that contains `part`, cut at the image's border but not at
// any crop.
[[nodiscard]] inline PixelRect whole_block(const PixelRect& part, const V2i& image_size_px) {
  const V2i corner(part.min.x / kBlockSize * kBlockSize, part.min.y / kBlockSize * kBlockSize);
  return {corner,
          V2i(std::min(corner.x + kBlockSize, image_size_px.x), std::min(corner.y + kBlockSize, image_size_px.y))};
}

// Traces camera rays, one sample of one whole block at a time: close together and almost parallel.
// An accelerator's answers may depend on the group of rays, so a block that is cut by a crop or a
// replay is traced as a whole, and the hits outside of the cut are dropped: a pixel is the same in
// every crop.
inline void intersect_camera_rays(const accel::Accelerator& accelerator, const Camera& camera, const Sampler& sampler,
                                  const PixelFilter& filter, const PixelRect& block, const SampleRange& samples,
                                  std::span<const accel::Ray> rays, std::span<accel::Hit> hits) {
  const PixelRect whole = whole_block(block, camera.size_px());
  assert(block.max.x <= whole.max.x && block.max.y <= whole.max.y); // within one block of the grid
  const auto group = static_cast<size_t>(block.pixel_count());
  assert(rays.size() == group * samples.count() && hits.size() == rays.size());
  for (uint32_t s = 0; s < samples.count(); ++s) {
    const std::span<accel::Hit> own = hits.subspan(s * group, group);
    if (whole.pixel_count() == block.pixel_count()) {
      accelerator.intersect_coherent(rays.subspan(s * group, group), own);
      continue;
    }
    constexpr size_t kWhole = kBlockSize * kBlockSize;
    std::array<CameraSample, kWhole> whole_samples;
    std::array<accel::Ray, kWhole> whole_rays;
    std::array<accel::Hit, kWhole> whole_hits;
    const auto whole_count = static_cast<size_t>(whole.pixel_count());
    generate_camera_rays(camera, sampler, filter, whole, {samples.first + s, samples.first + s + 1}, whole_samples,
                         whole_rays);
    accelerator.intersect_coherent(std::span(whole_rays).first(whole_count), std::span(whole_hits).first(whole_count));
    size_t slot = 0;
    for (int y = block.min.y; y < block.max.y; ++y)
      for (int x = block.min.x; x < block.max.x; ++x)
        own[slot++] = whole_hits[static_cast<size_t>((y - whole.min.y) * whole.width() + (x - whole.min.x))];
  }
}

} // namespace kindling
