// The path tracer: unidirectional, iterative, batched; light and BSDF sampling joined by multiple importance sampling.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/integrator/guided_scattering.h"
#include "renderer/integrator/integrator.h"
#include "renderer/integrator/path_state.h"

namespace kindling {

// Estimates the rendering equation (Kajiya 1986) with next-event estimation and the power heuristic (Veach 1997, section 9.2).
// Unbiased up to the bounce limits, as long as no clamp is set and caustics are full.
class PathIntegrator final : public Integrator {
 public:
  PathIntegrator(const IntegratorSettings& settings, const World& world, const Camera& camera, const Sampler& sampler,
                 const PixelFilter& filter, AovSet aovs, const Guide* guide = nullptr);

  [[nodiscard]] std::unique_ptr<ThreadContext> make_context() const override;
  void render_block(const PixelRect& block, const SampleRange& samples, ThreadContext& context,
                    Film& film) const override;

 private:
  // A surface at which a path scatters.
  struct Vertex {
    const SurfacePoint& surface;
    const Frame& frame; // around the shading normal
    GuidedBsdf bsdf;
    uint32_t slot; // of the path
    const ShadeGroup::Member& member;
  };

  // The stages of a wave, in the order in which they run.
  void start_wave(const PixelRect& block, const SampleRange& samples, PathContext& context) const;
  void trace_camera_rays(const PixelRect& block, const SampleRange& samples, PathContext& context) const;
  void shade(PathContext& context) const;
  void trace_shadows(PathContext& context) const;
  void trace_bounces(PathContext& context) const;
  void finish_wave(size_t path_count, PathContext& context, Film& film) const;

  // Steps of shade(), for the active paths [first, first + count).
  void prepare_group(size_t first, size_t count, PathContext& context) const;
  void sample_lights(size_t first, size_t count, PathContext& context) const;
  // The same for one path.
  void shade_hit(size_t i, ShadeGroup::Member& member, PathContext& context) const;
  void shade_escaped(const accel::Ray& ray, const Environment::Location& at, uint32_t slot, PathContext& context) const;
  [[nodiscard]] bool passes_through(const SurfacePoint& surface, uint32_t slot, PathContext& context) const;
  void continue_through(const accel::Ray& ray, const SurfacePoint& surface, uint32_t slot, PathContext& context) const;
  void add_emission(const accel::Ray& ray, const SurfacePoint& surface, PathState& state) const;
  void light_vertex(const Vertex& vertex, PathContext& context) const;
  [[nodiscard]] bool sample_bounce(const Vertex& vertex, PathContext& context) const;
  void record_surface(const SurfacePoint& surface, const GltfBsdf* bsdf, uint32_t slot, PathContext& context) const;
  [[nodiscard]] bool count_bounce(Lobe lobe, PathState& state) const;

  IntegratorSettings settings_;
  const World& world_;
  const Camera& camera_;
  Sampler sampler_;
  PixelFilter filter_;
  float sample_width_; // of the cone of a sample, relative to its pixel's
  AovSet aovs_;
  const Guide* guide_; // null: unguided
};

} // namespace kindling
