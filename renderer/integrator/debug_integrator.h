// Debug views, which show one property of the first surface as a color.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/integrator/integrator.h"

namespace kindling {

// The background is black with alpha 0. Normals map [-1, 1] to [0, 1]; depth is 1 at the camera and
// falls to 0 at the far end of the scene; instances and materials have a color hashed from their
// number.
class DebugIntegrator final : public Integrator {
 public:
  DebugIntegrator(const IntegratorSettings& settings, const World& world, const Camera& camera, const Sampler& sampler,
                  const PixelFilter& filter);

  [[nodiscard]] std::unique_ptr<ThreadContext> make_context() const override;
  uint32_t render_block(const PixelRect& block, const SampleRange& samples, ThreadContext& context,
                        Film& film) const override;

 private:
  [[nodiscard]] Rgb view_of(const accel::Ray& ray, const accel::Hit& hit) const;

  IntegratorKind kind_;
  uint32_t batch_size_;
  const World& world_;
  const Camera& camera_;
  Sampler sampler_;
  PixelFilter filter_;
};

} // namespace kindling
