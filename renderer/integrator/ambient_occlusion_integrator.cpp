// Ambient occlusion with one cosine-distributed occlusion ray for each camera sample.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/integrator/ambient_occlusion_integrator.h"

#include "renderer/integrator/first_hit_context.h"
#include "renderer/integrator/stages/sample_cone.h"
#include "renderer/sampling/warp.h"

#include <cassert>

namespace kindling {

AmbientOcclusionIntegrator::AmbientOcclusionIntegrator(const IntegratorSettings& settings, const World& world,
                                                       const Camera& camera, const Sampler& sampler,
                                                       const PixelFilter& filter)
    : batch_size_(settings.batch_size),
      distance_m_(settings.ao_distance_m > 0.0f ? settings.ao_distance_m : world.bounds.size().length() * 0.1f),
      world_(world), camera_(camera), sampler_(sampler), filter_(filter) {}

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
    SurfacePoint surface;
    for (size_t slot = 0; slot < count; ++slot) {
      context.gray[slot] = 0.0f;
      if (!context.hits[slot].is_hit()) continue;
      const RayCone cone = sample_cone(camera_, context.rays[slot].direction, sample_width(sampler_));
      world_.surface_at(context.rays[slot], context.hits[slot], surface,
                        {.width_m = cone.width_at(context.hits[slot].t)});
      const CameraSample& camera_sample = context.camera_samples[slot];
      const V2f u = Sampler::sample_2d(camera_sample.address, kFirstBounceDimension + kDirectionDimension);
      const V3f wi = Frame::around(surface.shading_normal).to_world(sample_cosine_hemisphere(u));
      if (wi.dot(surface.geometric_normal) <= 0.0f) continue;
      context.occlusion_slots.push_back(static_cast<uint32_t>(slot));
      context.occlusion_rays.push_back({.origin = offset_ray_origin(surface, wi),
                                        .t_min = 0.0f,
                                        .direction = wi,
                                        .t_max = distance_m_,
                                        .key = hash_combine(camera_sample.address.key, kFirstBounceDimension),
                                        .time = context.rays[slot].time,
                                        .index = camera_sample.address.index});
    }
    context.occluded.resize(context.occlusion_rays.size());
    world_.accelerator().occluded(context.occlusion_rays, context.occluded);
    context.counters.shadow += context.occlusion_rays.size();
    if (world_.abandoned()) return false;
    for (size_t i = 0; i < context.occlusion_slots.size(); ++i)
      context.gray[context.occlusion_slots[i]] = context.occluded[i] ? 0.0f : 1.0f;
    for (size_t slot = 0; slot < count; ++slot)
      film.add(context.camera_samples[slot].pixel, {Rgb(context.gray[slot]), context.hits[slot].is_hit() ? 1.0f : 0.0f,
                                                    context.camera_samples[slot].filter_weight});
    return true;
  });
}

} // namespace kindling
