// Debug views, which show one property of the first surface as a color.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/integrator/first_hits.h"
#include "renderer/integrator/integrator.h"
#include "renderer/integrator/stages/first_hit.h"

namespace kindling {

// The colors are those of FirstHitStages::color_of(); the background is black with alpha 0.
class DebugIntegrator final : public Integrator {
 public:
  DebugIntegrator(const IntegratorSettings& settings, const World& world, const Camera& camera, const Sampler& sampler,
                  const PixelFilter& filter, AovSet aovs, const AovInputs& inputs);

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
