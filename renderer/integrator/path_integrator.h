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
  [[nodiscard]] std::unique_ptr<PathContext> make_path_context() const; // the same, for callers that set its recorder
  void render_block(const PixelRect& block, const SampleRange& samples, ThreadContext& context,
                    Film& film) const override;

 private:
  // The layers of a surface as a path meets them. A path that is refracted takes on the wavelength, and its weight if it had none.
  struct LayersHere {
    const LayerParameters* parameters = nullptr;
    float wavelength_nm = 0.0f; // 0: all
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
    const LayersHere* layers; // null: the surface has none
  };

  // The stages of a wave, in the order in which they run.
  void start_batch(const PixelRect& block, const SampleRange& samples, PathContext& context) const;
  void trace_camera_rays(const PixelRect& block, const SampleRange& samples, PathContext& context) const;
  void shade(PathContext& context) const;
  void trace_shadows(PathContext& context) const;
  void trace_bounces(PathContext& context) const;
  void finish_batch(size_t path_count, PathContext& context, Film& film) const;

  // Steps of shade(), for the active paths [first, first + count).
  void prepare_group(size_t first, size_t count, PathContext& context) const;
  void sample_lights(size_t first, size_t count, PathContext& context) const;
  // The same for one path.
  void shade_hit(size_t i, ShadeGroup::Member& member, PathContext& context) const;
  void scatter(const accel::Ray& ray, Vertex&& vertex, PathContext& context) const;
  void shade_escaped(const accel::Ray& ray, const Environment::Location& at, uint32_t slot, PathContext& context) const;
  void regularize(SurfacePoint& surface, const PathState& state, uint32_t sample_index) const; // of caustics
  void add_emission(const accel::Ray& ray, const SurfacePoint& surface, PathState& state) const;
  void add_shapes(size_t i, PathContext& context) const; // path_shapes.cpp
  void light_vertex(const Vertex& vertex, PathContext& context) const;
  [[nodiscard]] bool sample_bounce(const Vertex& vertex, PathContext& context) const;
  // Only where the context keeps surfaces.
  void record_surface(const accel::Ray& ray, const SurfacePoint& surface, const SurfaceBsdf* bsdf, uint32_t slot,
                      PathContext& context) const;
  [[nodiscard]] bool count_bounce(Lobe lobe, PathState& state) const;

  // Layers and media, path_media.cpp.
  // Sets what the layers of a surface that has some take from the path. `media`: of the path, where its state says that it is in some.
  [[nodiscard]] LayersHere resolve_layers(SurfacePoint& surface, const Frame& frame, const PathState& state,
                                          const MediumStack& media, float u_wavelength) const;
  // The path goes on from the other side of the surface: by itself, and refracted.
  static void pass_boundary(const SurfacePoint& surface, PathState& state, MediumStack& media);
  static void cross_boundary(const Vertex& vertex, PathState& state, MediumStack& media);
  // Absorption up to the hit of active path `i`. False: the path has ended, or was scattered on the way and goes on from there.
  [[nodiscard]] bool travel_medium(size_t i, PathContext& context) const;
  [[nodiscard]] Rgb medium_transmittance(const MediumStack& media, float distance) const;
  // Of the medium between a vertex and a light on the side of wo (side > 0) or beyond, and what is refracted to there.
  [[nodiscard]] Rgb transmittance_to_light(const Vertex& vertex, float side, float distance,
                                           const PathContext& context) const;
  // Straight on, path_transparency.cpp.
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
  float sample_width_; // of the cone of a sample, relative to its pixel's
  AovSet aovs_;
  const Guide* guide_; // null: unguided
};

} // namespace kindling
