// Unidirectional, batched path tracer with multiple importance sampling of lights and BSDFs.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/integrator/guided_scattering.h"
#include "renderer/integrator/integrator.h"
#include "renderer/integrator/path_state.h"

namespace kindling {

// Estimates the rendering equation (Kajiya 1986) with next-event estimation and the power heuristic
// (Veach 1997, section 9.2). Unbiased up to the bounce limits, as long as no clamp is set and
// caustics are full.
class PathIntegrator final : public Integrator {
 public:
  PathIntegrator(const IntegratorSettings& settings, const World& world, const Camera& camera, const Sampler& sampler,
                 const PixelFilter& filter, AovSet aovs, const Guide* guide = nullptr);

  [[nodiscard]] std::unique_ptr<ThreadContext> make_context() const override;
  [[nodiscard]] std::unique_ptr<PathContext> make_path_context() const; // the same, for callers that set its recorder
  uint32_t render_block(const PixelRect& block, const SampleRange& samples, ThreadContext& context,
                        Film& film) const override;

 private:
  // The layers of a surface as one path meets them. A path that is refracted takes on the
  // wavelength, and the weight too if it had no wavelength before.
  struct LayersHere {
    const LayerParameters* parameters = nullptr;
    float wavelength_nm = 0.0f; // 0: all wavelengths
    Rgb wavelength_weight{1.0f};
  };
  // A surface at which a path scatters.
  struct Vertex {
    const SurfacePoint& surface;
    const Frame& frame; // around the shading normal
    GuidedBsdf bsdf;
    uint32_t slot; // of the path
    float time;    // of its rays
    const ShadeGroup::Member& member;
    const LayersHere* layers; // null: the surface has no layers
  };

  // The stages of a batch, in the order in which they run.
  void start_batch(const PixelRect& block, const SampleRange& samples, PathContext& context) const;
  void trace_camera_rays(const PixelRect& block, const SampleRange& samples, PathContext& context) const;
  void shade(PathContext& context) const;
  void trace_shadows(PathContext& context) const;
  void trace_bounces(PathContext& context) const;
  void finish_batch(size_t path_count, PathContext& context, Film& film) const;

  // Steps of shade(), for the active paths [first, first + count).
  void prepare_group(size_t first, size_t count, PathContext& context) const;
  void sample_lights(size_t first, size_t count, PathContext& context) const;
  // Steps of shade() for one path.
  void shade_hit(size_t i, ShadeGroup::Member& member, PathContext& context) const;
  void scatter(const accel::Ray& ray, Vertex&& vertex, PathContext& context) const;
  void shade_escaped(const accel::Ray& ray, const Environment::Location& at, uint32_t slot, PathContext& context) const;
  void regularize(SurfacePoint& surface, const PathState& state, uint32_t sample_index) const; // caustics.h
  void add_emission(const accel::Ray& ray, const SurfacePoint& surface, PathState& state) const;
  void add_shapes(size_t i, PathContext& context) const; // path_shapes.cpp
  void light_vertex(const Vertex& vertex, PathContext& context) const;
  [[nodiscard]] bool sample_bounce(const Vertex& vertex, PathContext& context) const;
  // Stores the first surface for AOVs; called only if the context has memory for surfaces.
  void record_surface(const accel::Ray& ray, const SurfacePoint& surface, const SurfaceBsdf* bsdf, uint32_t slot,
                      PathContext& context) const;
  [[nodiscard]] bool count_bounce(Lobe lobe, PathState& state) const;

  // Layers and media (path_media.cpp).
  //
  // Completes the surface's layers with what depends on the path: indices of refraction and
  // wavelength. `media` is read only if state.in_medium.
  [[nodiscard]] LayersHere resolve_layers(SurfacePoint& surface, const Frame& frame, const PathState& state,
                                          const MediumStack& media, float u_wavelength) const;
  // Moves the path to the other side of the surface: straight, and refracted.
  static void pass_boundary(const SurfacePoint& surface, PathState& state, MediumStack& media);
  static void cross_boundary(const Vertex& vertex, PathState& state, MediumStack& media);
  // Applies absorption and scattering up to the hit of active path `i`. False if the path does not
  // reach its hit: it has ended, or was scattered on the way and has a new ray.
  [[nodiscard]] bool travel_medium(size_t i, PathContext& context) const;
  [[nodiscard]] Rgb medium_transmittance(const MediumStack& media, float distance) const;
  // Returns the transmittance between a vertex and a light on the side of wo (side > 0) or beyond
  // the surface; beyond, it includes the weight of the wavelength.
  [[nodiscard]] Rgb transmittance_to_light(const Vertex& vertex, float side, float distance,
                                           const PathContext& context) const;
  // Partial coverage and thin walls (path_transparency.cpp).
  [[nodiscard]] bool passes_through(float probability, uint32_t slot, PathContext& context) const;
  [[nodiscard]] bool passes_through(const Vertex& vertex, PathContext& context) const;
  void continue_through(const accel::Ray& ray, const SurfacePoint& surface, uint32_t slot, PathContext& context) const;
  void tint_shadows(PathContext& context) const;
  [[nodiscard]] Rgb thin_wall_transmittance(SurfacePoint& surface, const V3f& wo) const;

  IntegratorSettings settings_;
  const World& world_;
  const Camera& camera_;
  Sampler sampler_;
  PixelFilter filter_;
  float sample_width_; // width of a sample's cone relative to its pixel's
  AovSet aovs_;
  const Guide* guide_; // null: unguided
};

} // namespace kindling
