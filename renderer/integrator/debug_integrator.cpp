// Batches of camera rays for the debug views.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/integrator/debug_integrator.h"

#include "renderer/integrator/first_hit_context.h"

#include <cassert>

namespace kindling {

DebugIntegrator::DebugIntegrator(const IntegratorSettings& settings, const World& world, const Camera& camera,
                                 const Sampler& sampler, const PixelFilter& filter, AovSet aovs,
                                 const AovInputs& inputs)
    : batch_size_(settings.batch_size), world_(world), camera_(camera), sampler_(sampler),
      stages_(make_first_hit_stages(settings, world, camera, sampler)), filter_(filter),
      first_hits_(world, camera, filter_, aovs, inputs) {}

std::unique_ptr<ThreadContext> DebugIntegrator::make_context() const {
  return std::make_unique<FirstHitContext>(batch_size_);
}

uint32_t DebugIntegrator::render_block(const PixelRect& block, const SampleRange& samples, ThreadContext& thread,
                                       Film& film) const {
  assert(dynamic_cast<FirstHitContext*>(&thread));
  auto& context = static_cast<FirstHitContext&>(thread);
  return context.for_each_batch(world_, camera_, sampler_, filter_, block, samples, batch_size_, [&](size_t count) {
    if (world_.abandoned()) return false;
    for (size_t slot = 0; slot < count; ++slot) {
      const bool hit = context.hits[slot].is_hit();
      const CameraSample& sample = context.camera_samples[slot];
      film.add(sample.pixel, {hit ? stages_.color_of(context.rays[slot], context.hits[slot]) : Rgb(0.0f),
                              hit ? 1.0f : 0.0f, sample.filter_weight, sample.sample_index});
      if (first_hits_.wanted()) first_hits_.add(sample, context.hits[slot], film);
    }
    return true;
  });
}

} // namespace kindling
