// Thread context of integrators that stop at the first hit.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/integrator/camera_stage.h"

#include <cassert>
#include <vector>

namespace kindling {

class FirstHitContext final : public ThreadContext {
 public:
  explicit FirstHitContext(size_t batch_size) : camera_samples(batch_size), rays(batch_size), hits(batch_size) {
    occlusion_rays.reserve(batch_size);
    occlusion_slots.reserve(batch_size);
    occluded.reserve(batch_size);
    gray.resize(batch_size);
  }

  // Calls `shade_batch(path_count)` for each batch of the block, with camera_samples, rays and hits
  // filled; it returns false if the batch is abandoned. Returns the samples of each pixel that were
  // added.
  template <typename ShadeBatch>
  uint32_t for_each_batch(const World& world, const Camera& camera, const Sampler& sampler, const PixelFilter& filter,
                          const PixelRect& block, const SampleRange& samples, uint32_t batch_size,
                          const ShadeBatch& shade_batch) {
    const uint32_t per_batch = samples_per_batch(block, batch_size);
    for (uint32_t done = 0; done < samples.count(); done += per_batch) {
      const uint32_t first = samples.first + done;
      const SampleRange batch{first, first + std::min(per_batch, samples.count() - done)};
      const size_t count = static_cast<size_t>(block.pixel_count()) * batch.count();
      assert(count <= camera_samples.size());
      rays.resize(count);
      hits.resize(count);
      generate_camera_rays(camera, sampler, filter, block, batch, camera_samples, rays);
      intersect_camera_rays(world.accelerator(), camera, sampler, filter, block, batch, rays, hits);
      counters.camera += count;
      counters.paths += count;
      if (!shade_batch(count)) return done;
    }
    return samples.count();
  }

  std::vector<CameraSample> camera_samples;
  std::vector<accel::Ray> rays;
  std::vector<accel::Hit> hits;
  std::vector<accel::Ray> occlusion_rays;
  std::vector<uint32_t> occlusion_slots;
  std::vector<uint8_t> occluded;
  std::vector<float> gray; // by slot
};

} // namespace kindling
