// Ambient occlusion: the unoccluded fraction of the cosine-weighted hemisphere up to a distance.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/integrator/first_hits.h"
#include "renderer/integrator/integrator.h"
#include "renderer/integrator/stages/first_hit.h"

namespace kindling {

// Renders gray in [0, 1], 1 where nothing is near, and a black background with alpha 0.
class AmbientOcclusionIntegrator final : public Integrator {
 public:
  AmbientOcclusionIntegrator(const IntegratorSettings& settings, const World& world, const Camera& camera,
                             const Sampler& sampler, const PixelFilter& filter, AovSet aovs, const AovInputs& inputs);

  [[nodiscard]] std::unique_ptr<ThreadContext> make_context() const override;
  uint32_t render_block(const PixelRect& block, const SampleRange& samples, ThreadContext& context,
                        Film& film) const override;

 private:
  uint32_t batch_size_;
  const World& world_;
  const Camera& camera_;
  Sampler sampler_;
  FirstHitStages stages_;
  PixelFilter filter_;
  FirstHits first_hits_;
};

} // namespace kindling
