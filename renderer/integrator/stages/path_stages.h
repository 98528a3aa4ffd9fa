// The stages of a path, each for one path at a time: the same code on every device.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/camera/camera.h"
#include "renderer/film/film_surface.h"
#include "renderer/guiding/bright_patches.h"
#include "renderer/guiding/caustic_guide.h"
#include "renderer/guiding/light_selection_tree.h"
#include "renderer/guiding/volume_guide.h"
#include "renderer/integrator/integrator_settings.h"
#include "renderer/integrator/stages/guided_scattering.h"
#include "renderer/integrator/stages/light_draws.h"
#include "renderer/integrator/stages/light_path_view.h"
#include "renderer/integrator/stages/path_state.h"
#include "renderer/sampling/bounce_draws.h"
#include "renderer/world/world_view.h"

#include <cstdint>
#include <optional>

namespace kindling {

struct ManifoldView;
struct ReusedPath;

// One path, as the stages see it. All members belong to its slot.
struct PathInFlight {
  uint32_t slot;
  const CameraSample& sample;
  PathState& state;
  MediumStack& media;   // valid only if state.in_medium
  FilmSurface* surface; // the first surface, for AOVs; null: no AOV needs it
  // The number of the sample by which it has its photon map: its own, or with sample rates its
  // level.
  uint32_t map_sample = 0;
};

// Numbers that are drawn at a surface before it is shaded.
struct SurfaceDraws {
  BounceDraws draws;                                       // choice.y chooses the lobe; light and spare the light
  const LightProbabilities* light_probabilities = nullptr; // learned for the surface's position; null: none
  const LightDraws* reflections = nullptr; // of reflection_sample_count() samples; null: drawn when they are used
  // The place of PathStages::mirrored() in the environment; null: found when it is used.
  const EnvironmentView::Location* mirrored = nullptr;
};

// A light sample whose shadow ray is not traced yet.
struct ShadowRecord {
  Rgb contribution;  // added to the path if nothing is in between
  uint32_t slot = 0; // of the path
  uint32_t light_class = kDirect;
};

// Everything that the stages read. Each stage takes one path from one ray to the next:
//
//   scatter_distance()     scattering in a medium before the hit: then only scatter_in_medium()
//   measure_footprint()    the ray's cone at its hit
//   WorldView::surface_at  the surface
//   draws_address()        what its random numbers are drawn for
//   light_query()          what a light is sampled for
//   LightSetView::sample   a light, or several
//   shade_hit()            emission, the contributions of light samples, and the next ray
//   shade_escaped()        instead of these: light from beyond the scene
//   pass_thin_wall()       a thin wall on the way of a shadow ray that nothing else blocks
//   add_light()            the contribution of an unblocked shadow ray
//
// Stages hand their results to a sink:
//
//   void extend(const PathInFlight&, const accel::Ray&)           the path continues with this ray
//   void add_shadow(const accel::Ray&, const ShadowRecord&)       a shadow ray is to be traced
//   gather_photons()                                              adds the light of photons nearby
//   kBesideLightPaths                                             false: never with light paths
//   kManifolds, add_manifold_light()                       false: never with manifold sampling
//   records(), arrive(), escape(), reflect(), offer_light()       for the training of a guide
//   kReuses, reused()                   the record of a path that is shared (reuse_paths.h); null:
//                                       it is not
//   kSplits, first_surface(), scatter_first(),                   for light groups and passes, if
//   split_emission(), split_environment()                       kSplits (split_light.h)
//   surface_event(), scatter_event(), escaped_event()             for the replay of a sample
//
// batch_sink.h has one with all of them.
struct PathStages {
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
    const accel::Hit& hit;
    const Frame& frame; // around the shading normal
    GuidedBsdf bsdf;
    float time; // of the path's rays
    const SurfaceDraws& sampled;
    const LayersHere* layers; // null: the surface has no layers
    // Light samples leave the environment to the direction of the path: leaves_environment().
    bool environment_left = false;
  };

  // Widens the cone of a path by the way to its hit; returns the footprint there.
  [[nodiscard]] RayFootprint measure_footprint(const accel::Ray& ray, float distance_m, PathState& state) const;

  // True if the surface reflects light, so that a direction is sampled.
  [[nodiscard]] static bool reflects(const SurfacePoint& surface, const PathState& state) {
    return !surface.unlit && !state.emission_only;
  }
  // True if a light is sampled at a surface that reflects. At the smooth boundary of a volume of
  // glass it would be in vain: it reflects and refracts into exact directions alone, so
  // LayeredBsdf::eval() is black. regularize() may make it rough.
  [[nodiscard]] bool samples_light(const SurfacePoint& surface) const {
    return !surface.layered || !surface.layers.boundary || settings.caustics != Caustics::full ||
           !is_clear_glass(surface.bsdf, surface.layers.bsdf);
  }
  // True if a surface with layers is clear glass that is met from outside.
  [[nodiscard]] bool favors_reflection(const SurfacePoint& surface, const PathState& state) const;
  // Returns the direction in which a surface mirrors a ray; unit.
  [[nodiscard]] static V3f mirrored(const V3f& direction, const SurfacePoint& surface) {
    return direction - surface.shading_normal * (2.0f * surface.shading_normal.dot(direction));
  }
  // Returns LayerParameters::reflection_odds there, given the location of mirrored(); else it is 1.
  [[nodiscard]] float reflection_odds(const EnvironmentView::Location& mirrored) const;
  // Mixes the guides of directions into the BSDF of a surface: a GuidedBsdf, or a GuideMixture with
  // the surface's shading normal and lobes.
  template <typename Guided, typename... Surface>
  void guide(Guided& guided, const V3f& position, const Surface&... surface) const {
    if (patches) guided.guide_to(*patches, position, surface...);
    if (to_environment) guided.guide_to(*to_environment, world->lights.environment, position, surface...);
    if (caustics) guided.guide_to(*caustics, position, surface...);
  }
  [[nodiscard]] bool guides_directions() const { return patches || to_environment || caustics; }
  // Returns the number of light samples of a path at the surface that it has reached.
  [[nodiscard]] uint32_t light_sample_count(const PathState& state) const {
    return state.bounce == 0 ? static_cast<uint32_t>(settings.direct_samples) : 1;
  }
  // Returns the most shadow rays that a path has at such a surface.
  [[nodiscard]] uint32_t max_shadow_rays(const PathState& state) const {
    return state.bounce == 0 ? settings.max_shadow_rays() : 1;
  }
  // Returns the number of reflection samples of a path at a surface, beside light samples: of the
  // environment, in directions of the glossy lobes alone, which a path seldom takes by itself.
  [[nodiscard]] uint32_t reflection_sample_count(const Vertex& vertex, const PathState& state) const {
    return state.bounce == 0 && settings.reflection_samples > 0 && world->lights.has_environment &&
                   vertex.bsdf.bsdf().has_microfacets()
               ? static_cast<uint32_t>(settings.reflection_samples)
               : 0;
  }
  // Returns what the random numbers of one of them are drawn for: LightDraws.
  [[nodiscard]] static BounceAddress reflection_address(const PathInFlight& path, uint32_t number, uint32_t count) {
    return {light_sample_address(path.sample.address, number, count), path.state.dimension(kReflectionDimension - 1)};
  }
  // Returns what the random numbers of a surface that reflects are drawn for: SurfaceDraws::draws.
  [[nodiscard]] static BounceAddress draws_address(const PathInFlight& path) {
    return {path.sample.address, path.state.dimension(kDirectionDimension)};
  }
  // Returns SurfaceDraws::light_probabilities.
  [[nodiscard]] const LightProbabilities* learned_probabilities(const SurfacePoint& surface) const;
  // Returns the query for a light.
  [[nodiscard]] LightQuery light_query(const SurfacePoint& surface, float time, const SurfaceDraws& sampled,
                                       const PathInFlight& path) const;
  // Returns the query for one of several light samples, given the numbers that are drawn for its
  // light_sample_address().
  [[nodiscard]] static LightQuery light_query(LightQuery first, const LightDraws& draws) {
    first.u = draws.light;
    first.digits = draws.spare;
    return first;
  }

  // Adds the light of the shapes that the ray crosses on its way to its hit, or to infinity. Shapes
  // block nothing. Camera rays do not see them, straight continuations through transparency
  // included.
  template <typename Sink>
  void add_shapes(const accel::Ray& ray, const accel::Hit& hit, const PathInFlight& path, const Sink& sink) const;
  void add_shapes_alone(const accel::Ray& ray, const accel::Hit& hit, const PathInFlight& path) const; // step of it
  // Returns that segment of the ray.
  [[nodiscard]] ShapeRay shape_ray(const accel::Ray& ray, const accel::Hit& hit, const PathInFlight& path) const;

  // Returns the distance at which a medium scatters a path before it reaches the hit, if it does:
  // then scatter_in_medium() is called in place of shade_hit(), and the surface does not matter.
  [[nodiscard]] std::optional<float> scatter_distance(float hit_distance, const PathInFlight& path) const;
  template <typename Sink>
  void scatter_in_medium(const accel::Ray& ray, float distance, const PathInFlight& path, Sink& sink) const;

  // `lights` has the samples for light_query(), light_sample_count() or none: size(), and [number],
  // a std::optional<LightSample>. It is read, like `sampled`, only if the surface reflects.
  template <typename Lights, typename Sink>
  void shade_hit(const accel::Ray& ray, const accel::Hit& hit, SurfacePoint& surface, const SurfaceDraws& sampled,
                 const Lights& lights, const PathInFlight& path, Sink& sink) const;
  template <typename Sink>
  void shade_escaped(const accel::Ray& ray, const EnvironmentView::Location& at, const PathInFlight& path,
                     Sink& sink) const;

  static void add_light(const ShadowRecord& record, PathState& state) {
    state.light[record.light_class] += record.contribution;
  }
  // The fate of a shadow ray at the nearest thin wall on its way.
  enum class ThinWall : uint8_t { blocks, passed, last };
  // Multiplies the contribution by the transmittance of the wall that the ray meets at `hit`.
  // `passed`: the ray starts behind the wall now; `last`: there is nothing more on its way.
  [[nodiscard]] ThinWall pass_thin_wall(const accel::Hit& hit, accel::Ray& ray, SurfacePoint& scratch,
                                        Rgb& contribution) const;

  // Returns the radiance of a path that has ended, within the clamps.
  [[nodiscard]] Rgb radiance_of(PathState& state) const;

  // Steps of shade_hit(). reach_surface() adds the emission; true: the path is scattered, by
  // scatter_at().
  template <typename Sink>
  [[nodiscard]] bool reach_surface(const accel::Ray& ray, const accel::Hit& hit, SurfacePoint& surface,
                                   const PathInFlight& path, Sink& sink) const;
  template <typename Lights, typename Sink>
  void scatter_at(const accel::Ray& ray, const accel::Hit& hit, SurfacePoint& surface, const SurfaceDraws& sampled,
                  const Lights& lights, const PathInFlight& path, Sink& sink) const;
  // shade_vertex() adds the light samples; true: the next direction is to be sampled, with the
  // record that it sets.
  template <typename Lights, typename Sink>
  [[nodiscard]] bool shade_vertex(const accel::Ray& ray, Vertex& vertex, const Lights& lights, const PathInFlight& path,
                                  Sink& sink, ReusedPath*& reused) const;
  template <typename Lights, typename Sink>
  void scatter(const accel::Ray& ray, Vertex&& vertex, const Lights& lights, const PathInFlight& path,
               Sink& sink) const;
  [[nodiscard]] static bool may_receive(const Vertex& vertex, const V3f& wi);
  // Returns whether light samples leave the environment to the direction of the path: in rough
  // glass whose lobe is narrower than the bundle of rays that the path stands for.
  [[nodiscard]] bool leaves_environment(const Vertex& vertex, const PathState& state) const;
  [[nodiscard]] static bool is_left(const Vertex& vertex, const LightSample& light);
  // Returns PathState::specular_cone after a vertex.
  [[nodiscard]] RayCone next_specular_cone(const Vertex& vertex, const GuidedBsdf::Sample& scattered,
                                           const PathState& state) const;
  [[nodiscard]] bool follows_specular_cone(const PathState& state) const { // step of it
    return specular_scale > 0.0f && state.specular_cone.spread >= 0.0f;
  }
  // The light samples at a surface and the reflection samples, which follow them.
  struct DirectCounts {
    uint32_t lights = 0, reflections = 0;
    [[nodiscard]] uint32_t all() const { return lights + reflections; }
  };
  // Adds the shadow rays of all of them.
  template <typename Lights, typename Sink>
  void add_lights(const Vertex& vertex, const Lights& lights, const PathInFlight& path, Sink& sink,
                  ReusedPath* reused) const;
  template <typename Lights, typename Sink>
  void add_lights_together(const Vertex& vertex, const Lights& lights, const DirectCounts& counts,
                           const PathInFlight& path, Sink& sink, ReusedPath* reused) const; // step of it
  // Density and weight of a sample: its light counts weight / density times.
  template <typename Real>
  struct SampleWeight {
    Real density, weight;
  };
  template <typename Real, typename Condition>
  [[nodiscard]] static SampleWeight<Real>
  weight_of(const DirectCounts& counts, const Real& light_pdf, const Real& bsdf_pdf, const Real& reflection_pdf,
            const Condition& environment, const Condition& reflected, const Condition& delta);
  // Steps of add_lights_together(): finds the samples that may bring light; adds some of them by
  // their weights, which weigh() computes given the BSDF towards them. That returns a mask of those
  // that bring light.
  struct ReadySamples;
  struct LightLanes;
  template <typename Lights>
  void find_ready(const Vertex& vertex, const Lights& lights, const DirectCounts& counts, const PathInFlight& path,
                  ReadySamples& samples) const;
  template <typename Sink>
  [[nodiscard]] bool only_weights(const Vertex& vertex, const PathInFlight& path, const Sink& sink) const;
  template <typename Lights, typename Sink>
  void add_weighted(const Vertex& vertex, const Lights& lights, const DirectCounts& counts, const ReadySamples& samples,
                    uint32_t first, const BsdfEvals& evals, const PathInFlight& path, Sink& sink) const;
  [[nodiscard]] static uint32_t weigh(const Vertex& vertex, const PathState& state, const DirectCounts& counts,
                                      const BsdfEvals& evals, LightLanes& lights);
  [[nodiscard]] static accel::Ray shadow_ray(const Vertex& vertex, const LightSample& light, uint32_t number,
                                             const PathInFlight& path);
  // Returns the probability with which a light sample at a surface chooses the environment.
  [[nodiscard]] float probability_of_environment(const Vertex& vertex) const {
    return world->lights.environment_probability(vertex.surface.position, vertex.surface.light_normal(),
                                                 vertex.sampled.light_probabilities);
  }
  // Returns the direction of a reflection sample; none: it finds no light.
  [[nodiscard]] static std::optional<V3f> reflection_direction(const Vertex& vertex, uint32_t number, uint32_t count,
                                                               const PathInFlight& path);
  // Returns the light of such a direction, with the density that light samples have for it.
  // `probability` is that of light samples to choose the environment.
  [[nodiscard]] LightSample reflected_light(float probability, const V3f& wi,
                                            const EnvironmentView::Location& at) const;
  // Adds the shadow ray of light sample or reflection sample `number`.
  template <typename Sink>
  void light_vertex(const Vertex& vertex, const LightSample& light, const BsdfEval& eval, uint32_t number,
                    const DirectCounts& counts, const PathInFlight& path, Sink& sink, ReusedPath* reused) const;
  // Samples the next direction; the path ends if there is none.
  template <typename Sink>
  void sample_bounce(const Vertex& vertex, const PathInFlight& path, Sink& sink, ReusedPath* reused) const;
  // `is_mirror_here` returns is_mirror() of the surface; it is called for first surfaces alone.
  template <typename Sink, typename IsMirror>
  [[nodiscard]] static ReusedPath* reused_path(Sink& sink, const PathInFlight& path, const SurfacePoint& surface,
                                               const IsMirror& is_mirror_here);
  // Returns the light that the surface's emission contributes to the path. `beside`: its weight
  // beside light paths, emission_weight() or 1.
  [[nodiscard]] Rgb light_of_emission(const accel::Ray& ray, const SurfacePoint& surface, float beside,
                                      const PathState& state) const;
  void regularize(SurfacePoint& surface, const PathState& state, uint32_t sample_index) const; // caustics.h
  // Records the data of a surface where a path ends or scatters; `bsdf` is null if it ends.
  void record_surface(const accel::Ray& ray, const SurfacePoint& surface, const SurfaceBsdf* bsdf,
                      const PathState& state, FilmSurface& record) const;
  // Counts a bounce whose direction had the density `pdf`. True if the surface that it leads to may
  // reflect in turn, within all limits.
  [[nodiscard]] bool count_bounce(Lobe lobe, float pdf, PathState& state) const;
  // True if a path may scatter at the end of so many bounces.
  [[nodiscard]] bool within_limits(int diffuse, int glossy, int transmissions) const {
    return diffuse <= settings.max_diffuse_bounces && glossy <= settings.max_glossy_bounces &&
           transmissions <= settings.max_transmission_bounces && diffuse + glossy <= settings.max_bounces;
  }

  // Light paths (light_path_weights.cpp), only if joins_light_paths(). Kernels that have none leave
  // all of it out.
  template <typename Sink>
  [[nodiscard]] bool joins_light_paths() const {
    return Sink::kBesideLightPaths && light_paths != nullptr;
  }
  // Sets PathState::light_path_scale of a path that is scattered at a hit. Returns the squared
  // radius within which photons are gathered there; 0: none are.
  [[nodiscard]] float find_light_path_scale(const accel::Ray& ray, const accel::Hit& hit, const SurfacePoint& surface,
                                            const PathInFlight& path) const;
  // The same at the boundary of a medium, where none are.
  void find_boundary_scale(const SurfacePoint& surface, PathState& state) const;
  // True if photons may be gathered at a surface that is no boundary.
  [[nodiscard]] bool gathers_photons(const PathInFlight& path) const;
  // Notes the share that light paths find of what is scattered into a direction, and what else
  // excludes them. Called before the path crosses the surface.
  void note_scattered(const Vertex& vertex, const GuidedBsdf::Sample& scattered, PathState& state) const;
  // The same, given LightPathView::narrow_steps(), which count only at casters.
  void note_scattered(const SurfacePoint& surface, uint32_t narrow, bool crosses, PathState& state) const;
  // Return the weights of a light sample (1 unless light_is_shared(); `narrow` as above), of an
  // emitter that was hit, of the environment, and of a shape, by its number among
  // LightSetView::punctuals.
  [[nodiscard]] bool light_is_shared(const SurfacePoint& surface, float side, const PathState& state) const;
  [[nodiscard]] float light_path_weight(const SurfacePoint& surface, float time, const LightSample& light,
                                        uint32_t narrow, const PathState& state) const;
  [[nodiscard]] float light_path_weight(const Vertex& vertex, const LightSample& light, float side,
                                        const PathState& state) const;
  [[nodiscard]] float emission_weight(const accel::Ray& ray, const SurfacePoint& surface, const PathState& state) const;
  [[nodiscard]] float environment_weight(const accel::Ray& ray, const EnvironmentView::Location& at,
                                         const PathState& state) const;
  [[nodiscard]] float shape_weight(const accel::Ray& ray, uint32_t punctual, const PathState& state) const;
  void add_shapes_beside_light_paths(const accel::Ray& ray, const accel::Hit& hit, const PathInFlight& path) const;

  // Layers and media (path_media.cpp). Completes the surface's layers with what depends on the
  // path: indices of refraction and wavelength, by the media on both sides, and the coat's normal,
  // by the frame. `media` is read only if state.in_medium.
  [[nodiscard]] LayersHere resolve_layers(SurfacePoint& surface, const Frame& frame, const PathState& state,
                                          const MediumStack& media, float u_wavelength) const;
  // The same without a frame, for layers without a coat.
  [[nodiscard]] LayersHere resolve_media(SurfacePoint& surface, const PathState& state, const MediumStack& media,
                                         float u_wavelength) const;
  // Moves the path to the other side of the surface: straight, and refracted.
  static void pass_boundary(const SurfacePoint& surface, PathState& state, MediumStack& media);
  static void cross_boundary(const SurfacePoint& surface, const LayersHere& layers, PathState& state,
                             MediumStack& media);
  // Applies the transmittance up to the hit, which scatter_distance() has let the path reach. False
  // if nothing is left.
  [[nodiscard]] bool cross_medium(float distance, const PathInFlight& path) const;
  // Samples the direction of a path that is scattered at a point in a medium of mean cosine g.
  [[nodiscard]] V3f scatter_direction(const V3f& direction, const V3f& position, float g, const SampleAddress& address,
                                      PathState& state) const;
  [[nodiscard]] Rgb medium_transmittance(const MediumStack& media, float distance) const;
  // Returns the transmittance between a surface and a light on the side of wo (side > 0) or beyond
  // the surface; beyond, it includes the weight of the wavelength. `layers` may be null.
  [[nodiscard]] Rgb transmittance_to_light(const SurfacePoint& surface, const LayersHere* layers, float side,
                                           float distance, const PathInFlight& path) const;
  // Partial coverage and thin walls (path_transparency.cpp).
  [[nodiscard]] static bool passes_through(float probability, const PathInFlight& path);
  [[nodiscard]] static bool passes_through(const Vertex& vertex, const PathInFlight& path);
  template <typename Sink>
  static void continue_through(const accel::Ray& ray, const SurfacePoint& surface, const PathInFlight& path,
                               Sink& sink);
  [[nodiscard]] Rgb thin_wall_transmittance(SurfacePoint& surface, const V3f& wo) const;

  IntegratorSettings settings;
  float sample_width = 1.0f; // width of a sample's cone relative to its pixel's
  // The factor from the spread of PathState::specular_cone to the width of an area of the
  // environment, in full turns; 0: glass and mirrors show it at its finest.
  float specular_scale = 0.0f;
  const WorldView* world = nullptr;
  const CameraView* camera = nullptr;
  const BrightPatches* patches = nullptr;                      // null: directions are not guided
  const LightSelectionTreeView* light_probabilities = nullptr; // null: not learned
  const EnvironmentGuideView* to_environment = nullptr;        // null: no directions follow the environment
  const CausticGuideView* caustics = nullptr;                  // null: no directions of caustics are known
  const VolumeGuideView* volumes = nullptr;                    // null: scattering in media is not guided
  const LightPathView* light_paths = nullptr;                  // null: none are traced
  const PresampledEnvironmentView* presampled = nullptr;       // null: samples of the environment are drawn
  const ManifoldView* manifolds = nullptr;                     // null: no manifold sampling
};

// Returns the key that stochastic transparency hashes for a ray. It differs for every bounce.
[[nodiscard]] inline uint32_t ray_key(const CameraSample& sample, uint32_t dimension) {
  return hash_combine(sample.address.key, dimension);
}

} // namespace kindling
