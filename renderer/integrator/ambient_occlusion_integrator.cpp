// Ambient occlusion with one cosine-distributed occlusion ray for each camera sample.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/integrator/ambient_occlusion_integrator.h"

#include "renderer/integrator/first_hit_context.h"

#include <cassert>
#include <optional>

namespace kindling {

AmbientOcclusionIntegrator::AmbientOcclusionIntegrator(const IntegratorSettings& settings, const World& world,
                                                       const Camera& camera, const Sampler& sampler,
                                                       const PixelFilter& filter, AovSet aovs, const AovInputs& inputs)
    : batch_size_(settings.batch_size), world_(world), camera_(camera), sampler_(sampler),
      stages_(make_first_hit_stages(settings, world, camera, sampler)), filter_(filter),
      first_hits_(world, camera, filter_, aovs, inputs) {}

std::unique_ptr<ThreadContext> AmbientOcclusionIntegrator::make_context() const {
  return std::make_unique<FirstHitContext>(batch_size_);
}

uint32_t AmbientOcclusionIntegrator::render_block(const PixelRect& block, const SampleRange& samples,
                                                  ThreadContext& thread, Film& film) const {
  assert(dynamic_cast<FirstHitContext*>(&thread));
  auto& context = static_cast<FirstHitContext&>(thread);
  return context.for_each_batch(world_, camera_, sampler_, filter_, block, samples, batch_size_, [&](size_t count) {
    context.occlusion_rays.clear();
    context.occlusion_slots.clear();
    for (size_t slot = 0; slot < count; ++slot) {
      context.gray[slot] = 0.0f;
      if (!context.hits[slot].is_hit()) continue;
      const std::optional<accel::Ray> ray =
          stages_.occlusion_ray(context.camera_samples[slot], context.rays[slot], context.hits[slot]);
      if (!ray) continue;
      context.occlusion_slots.push_back(static_cast<uint32_t>(slot));
      context.occlusion_rays.push_back(*ray);
    }
    context.occluded.resize(context.occlusion_rays.size());
    world_.accelerator().occluded(context.occlusion_rays, context.occluded);
    context.counters.shadow += context.occlusion_rays.size();
    if (world_.abandoned()) return false;
    for (size_t i = 0; i < context.occlusion_slots.size(); ++i)
      context.gray[context.occlusion_slots[i]] = context.occluded[i] ? 0.0f : 1.0f;
    for (size_t slot = 0; slot < count; ++slot) {
      const CameraSample& sample = context.camera_samples[slot];
      film.add(sample.pixel, {Rgb(context.gray[slot]), context.hits[slot].is_hit() ? 1.0f : 0.0f, sample.filter_weight,
                              sample.sample_index});
      if (first_hits_.wanted()) first_hits_.add(sample, context.hits[slot], film);
    }
    return true;
  });
}

} // namespace kindling
