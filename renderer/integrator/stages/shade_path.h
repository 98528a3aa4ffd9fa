// Shading of one path: emission, next-event estimation and the next direction.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/bsdf/bsdf_ranges.h"
#include "renderer/integrator/manifolds/manifold_light.h"
#include "renderer/integrator/stages/add_lights.h"
#include "renderer/integrator/stages/path_stages.h"
#include "renderer/integrator/stages/prepare_path.h"
#include "renderer/integrator/stages/random_walk.h"
#include "renderer/integrator/stages/reuse_paths.h"
#include "renderer/integrator/stages/sample_cone.h"
#include "renderer/integrator/stages/specular_cone.h"
#include "renderer/sampling/mis.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>

namespace kindling {

template <typename Sink>
inline void PathStages::add_shapes(const accel::Ray& ray, const accel::Hit& hit, const PathInFlight& path,
                                   const Sink& /*sink*/) const {
  if (path.state.bounce == 0) return;
  if (joins_light_paths<Sink>() && path.state.light_path_scale > 0.0f)
    add_shapes_beside_light_paths(ray, hit, path);
  else
    add_shapes_alone(ray, hit, path);
}

template <typename Lights, typename Sink>
inline void PathStages::shade_hit(const accel::Ray& ray, const accel::Hit& hit, SurfacePoint& surface,
                                  const SurfaceDraws& sampled, const Lights& lights, const PathInFlight& path,
                                  Sink& sink) const {
  if (reach_surface(ray, hit, surface, path, sink)) scatter_at(ray, hit, surface, sampled, lights, path, sink);
}

template <typename Sink>
inline bool PathStages::reach_surface(const accel::Ray& ray, const accel::Hit& hit, SurfacePoint& surface,
                                      const PathInFlight& path, Sink& sink) const {
  PathState& state = path.state;
  if (state.in_medium && !cross_medium(hit.t, path)) return false;
  sink.arrive(path, &surface);
  sink.surface_event(ray, hit, surface, state);
  if (!is_black(surface.emitted)) {
    const float beside = joins_light_paths<Sink>() ? emission_weight(ray, surface, state) : 1.0f;
    const Rgb light = light_of_emission(ray, surface, beside, state);
    state.light[state.light_class(state.bounce)] += light;
    if constexpr (Sink::kSplits) sink.split_emission(path, hit, surface, light);
  }
  if (surface.unlit || (state.emission_only && !surface.has_thin_wall())) {
    if (surface.alpha < 1.0f && passes_through(1.0f - surface.alpha, path))
      continue_through(ray, surface, path, sink);
    else if (path.surface)
      record_surface(ray, surface, nullptr, state, *path.surface);
    return false;
  }
  if (surface.layered && surface.layers.boundary && !surface.layers.entering && state.in_medium &&
      path.media.covered(surface.material)) {
    pass_boundary(surface, state, path.media);
    continue_through(ray, surface, path, sink);
    return false;
  }
  if (settings.caustics != Caustics::full) regularize(surface, state, path.sample.sample_index);
  return true;
}

template <typename Lights, typename Sink>
inline void PathStages::scatter_at(const accel::Ray& ray, const accel::Hit& hit, SurfacePoint& surface,
                                   const SurfaceDraws& sampled, const Lights& lights, const PathInFlight& path,
                                   Sink& sink) const {
  if (surface.layered) {
    const PathState& state = path.state;
    const Frame frame = Frame::with_tangent(surface.shading_normal, surface.layers.tangent);
    float& odds = surface.layers.bsdf.reflection_odds;
    odds = 1.0f;
    if (favors_reflection(surface, state))
      odds = reflection_odds(sampled.mirrored ? *sampled.mirrored
                                              : world->lights.environment.locate(mirrored(ray.direction, surface)));
    const LayersHere layers = resolve_layers(surface, frame, state, path.media, sampled.draws.choice.x);
    scatter(ray,
            Vertex{surface, hit, frame, GuidedBsdf(surface.bsdf, layers.parameters, frame, -ray.direction), ray.time,
                   sampled, &layers},
            lights, path, sink);
  } else {
    const Frame frame = Frame::around(surface.shading_normal);
    scatter(ray,
            Vertex{surface, hit, frame, GuidedBsdf(surface.bsdf, nullptr, frame, -ray.direction), ray.time, sampled,
                   nullptr},
            lights, path, sink);
  }
}

// Inlined at both calls, so that surfaces without layers get code of their own.
template <typename Lights, typename Sink>
[[gnu::always_inline]] inline void PathStages::scatter(const accel::Ray& ray, Vertex&& vertex, const Lights& lights,
                                                       const PathInFlight& path, Sink& sink) const {
  ReusedPath* reused = nullptr;
  if (shade_vertex(ray, vertex, lights, path, sink, reused)) sample_bounce(vertex, path, sink, reused);
}

template <typename Lights, typename Sink>
[[gnu::always_inline]] inline bool PathStages::shade_vertex(const accel::Ray& ray, Vertex& vertex, const Lights& lights,
                                                            const PathInFlight& path, Sink& sink,
                                                            ReusedPath*& reused) const {
  const SurfacePoint& surface = vertex.surface;
  const PathState& state = path.state;
  const bool reflects = !state.emission_only;
  guide(vertex.bsdf, surface.position);
  if (sink.records()) vertex.bsdf.find_allowed();
  reused =
      reused_path(sink, path, surface, [&] { return is_mirror(vertex.bsdf.bsdf().smooth_share(kMinSharedAlpha)); });
  if (reused) reused->note(surface, -ray.direction, state);
  vertex.environment_left = leaves_environment(vertex, state);
  if (reflects) add_lights(vertex, lights, path, sink, reused);
  if constexpr (Sink::kManifolds) {
    if (reflects && manifolds && !sink.records() && samples_light(surface))
      sink.add_manifold_light(path, manifold_light(*this, vertex, path));
  }
  // A partly transparent surface emits and reflects in proportion to its coverage; then the path
  // either scatters from it or passes through.
  if ((surface.alpha < 1.0f || surface.has_thin_wall()) && passes_through(vertex, path)) {
    continue_through(ray, surface, path, sink);
    return false;
  }
  if (path.surface) record_surface(ray, surface, &vertex.bsdf.bsdf(), state, *path.surface);
  if constexpr (Sink::kSplits) sink.first_surface(vertex, path);
  if (joins_light_paths<Sink>()) {
    const float radius2 = find_light_path_scale(ray, vertex.hit, surface, path);
    if (reflects && radius2 > 0.0f) sink.gather_photons(vertex, path, radius2);
  }
  return reflects;
}

// Returns the record of a path that is shared, at its first surface and at the second one, if
// others can be joined to it there; else null. First surfaces that are mostly mirrors find nothing
// that others do, and are left out. What is behind a partly transparent surface or a thin wall is
// not shared.
template <typename Sink, typename IsMirror>
inline ReusedPath* PathStages::reused_path(Sink& sink, const PathInFlight& path, const SurfacePoint& surface,
                                           const IsMirror& is_mirror_here) {
  if constexpr (Sink::kReuses) {
    const PathState& state = path.state;
    if (state.emission_only || state.bounce > 1 || state.in_medium || surface.layered || surface.alpha < 1.0f)
      return nullptr;
    ReusedPath* const reused = sink.reused(path);
    if (!reused) return nullptr;
    if (state.bounce == 0) return is_mirror_here() ? nullptr : reused;
    return reused->receives && state.transparent_surfaces == 0 ? reused : nullptr;
  } else {
    return nullptr;
  }
}

// Returns whether a surface is the boundary of a volume of glass that is neither metal nor has a
// diffuse base.
inline bool is_glass_alone(const PathStages::Vertex& vertex) {
  const SurfacePoint& surface = vertex.surface;
  return vertex.layers && surface.layers.boundary && surface.layers.bsdf.transmission == 1.0f &&
         surface.bsdf.metallic == 0.0f;
}

inline bool PathStages::leaves_environment(const Vertex& vertex, const PathState& state) const {
  if (!follows_specular_cone(state)) return false;
  if (!is_glass_alone(vertex) || vertex.surface.layers.entering || !samples_light(vertex.surface)) return false;
  return bundle_covers_lobe(*world, vertex.hit, vertex.surface, vertex.layers->parameters->eta, state.specular_cone,
                            specular_scale);
}

// Directions of a narrow lobe spread as those of a mirror or of clear glass would, if the normals
// of microfacets stay the same from ray to ray.
inline RayCone PathStages::next_specular_cone(const Vertex& vertex, const GuidedBsdf::Sample& scattered,
                                              const PathState& state) const {
  const bool narrow = scattered.pdf == 0.0f ||
                      (scattered.lobe != Lobe::diffuse && (scattered.pdf > kNarrowDensity || is_glass_alone(vertex)));
  if (!narrow || !follows_specular_cone(state)) return {.spread = -1.0f};
  return specular_cone(*world, vertex.hit, vertex.surface, scattered.wi,
                       vertex.layers ? vertex.layers->parameters->eta : 1.0f, state.specular_cone);
}

template <typename Sink>
inline void PathStages::sample_bounce(const Vertex& vertex, const PathInFlight& path, Sink& sink,
                                      ReusedPath* reused) const {
  const SurfacePoint& surface = vertex.surface;
  PathState& state = path.state;
  const uint32_t dimension = state.dimension(kDirectionDimension);
  const std::optional<GuidedBsdf::Sample> scattered =
      vertex.bsdf.sample(vertex.sampled.draws.choice.y, vertex.sampled.draws.direction);
  if (!scattered) return;
  const V3f wi = scattered->wi;
  assert(scattered->pdf >= 0.0f && std::abs(wi.length2() - 1.0f) < 1e-3f);
  const bool crosses = scattered->cosine < 0.0f;
  if ((wi.dot(surface.geometric_normal) < 0.0f) != crosses) return;
  state.throughput *= scattered->weight;
  if (is_black(state.throughput)) return;
  if (scattered->bsdf_pdf > 0.0f) state.guiding *= scattered->pdf / scattered->bsdf_pdf;
  if (scattered->pdf > 0.0f) sink.reflect(vertex, *scattered, path);
  if (path.surface && scattered->lobe == Lobe::diffuse) path.surface->guide_found = true;

  const bool shared_first = Sink::kReuses && reused && state.bounce == 0;
  if (Sink::kReuses && reused) {
    if (shared_first) {
      reused->value = scattered->weight * scattered->pdf;
      reused->pdf = scattered->pdf;
    } else { // the light of the tail alone counts from here on, but roulette as if all did
      reused->tail_wi = wi;
      reused->tail_pdf = scattered->pdf;
      state.guiding *= max_component(state.throughput);
      state.throughput = Rgb(1.0f);
    }
  }

  // Narrow bounces do not count for Russian roulette: what glass and mirrors show is to have as
  // many as it has when it is seen directly. At a first surface that is shared it would change the
  // density of what the path finds.
  if (state.roulette_bounces() >= settings.roulette_start_bounce && !shared_first) {
    const float survival = survival_of(state.throughput, state.guiding);
    if (vertex.sampled.draws.roulette >= survival) return;
    state.throughput /= survival;
  }

  if constexpr (Sink::kSplits) sink.scatter_first(vertex, *scattered, path);
  const auto lights = static_cast<float>(light_sample_count(state));
  const auto reflections = static_cast<float>(reflection_sample_count(vertex, state));
  if (joins_light_paths<Sink>()) note_scattered(vertex, *scattered, state);
  state.emission_only = !count_bounce(scattered->lobe, scattered->pdf, state);
  if (settings.caustics == Caustics::regularized) state.widest_lobe.add(scattered->lobe, surface.bsdf.roughness);
  state.cone = scattered_cone(state.cone, scattered->pdf);
  state.specular_cone = next_specular_cone(vertex, *scattered, state);
  state.environment_left = vertex.environment_left;
  state.bsdf_pdf = scattered->pdf / lights;
  state.reflection_ratio = scattered->pdf > 0.0f ? reflections * scattered->reflection_pdf / scattered->pdf : 0.0f;
  state.previous_position = surface.position;
  state.previous_normal = surface.light_normal();
  state.light_probabilities = vertex.sampled.light_probabilities;
  state.transparent_surfaces = 0;
  if (crosses) cross_boundary(surface, *vertex.layers, state, path.media);
  sink.extend(path, {.origin = offset_ray_origin(surface, wi),
                     .t_min = 0.0f,
                     .direction = wi,
                     .t_max = kInfinity,
                     .key = ray_key(path.sample, dimension),
                     .time = vertex.time,
                     .index = path.sample.address.index,
                     .flags = kHitPartlyTransparent});
}

// Continues the same ray behind the surface. The density of its direction is unchanged.
template <typename Sink>
inline void PathStages::continue_through(const accel::Ray& ray, const SurfacePoint& surface, const PathInFlight& path,
                                         Sink& sink) {
  if (++path.state.transparent_surfaces > kMaxTransparentSurfaces) return;
  if (!surface.has_thin_wall()) path.state.light_path_scale = 0.0f;
  accel::Ray behind = ray;
  behind.origin = offset_ray_origin(surface, ray.direction);
  sink.extend(path, behind);
}

template <typename Sink>
inline void PathStages::shade_escaped(const accel::Ray& ray, const EnvironmentView::Location& at,
                                      const PathInFlight& path, Sink& sink) const {
  PathState& state = path.state;
  sink.escape(path, ray);
  if (state.bounce == 0) {
    if (settings.transparent_background) {
      state.alpha = 1.0f - (state.throughput.x + state.throughput.y + state.throughput.z) / 3.0f; // through thin walls
      return;
    }
    if (settings.background) {
      state.light[kEmission] += state.throughput * *settings.background;
      if constexpr (Sink::kSplits) sink.split_environment(path, state.throughput * *settings.background);
      return;
    }
    if (!settings.environment_visible) return;
  }
  Rgb radiance;
  if (path.surface && path.surface->hit && !path.surface->guide_found)
    path.surface->guide_albedo = saturate(state.throughput * world->lights.environment_radiance(at));
  const bool competes = state.bsdf_pdf > 0.0f && !state.environment_left; // with light samples
  if (competes) {
    const EnvironmentEval environment =
        world->lights.environment_eval(state.previous_position, state.previous_normal, at, state.light_probabilities);
    // Directions of reflection samples compete, too (light_vertex()).
    const float directions = 1.0f + state.reflection_ratio;
    radiance = environment.radiance * (power_heuristic(state.bsdf_pdf * directions, environment.pdf) / directions);
  } else if (specular_scale > 0.0f && state.bounce > 0 && state.specular_cone.spread > 0.0f) {
    radiance = world->lights.environment_radiance(at, std::min(state.specular_cone.spread * specular_scale, kMaxTurns));
  } else {
    radiance = world->lights.environment_radiance(at);
  }
  if (joins_light_paths<Sink>()) radiance *= environment_weight(ray, at, state);
  state.light[state.light_class(state.bounce)] += state.throughput * radiance;
  if constexpr (Sink::kSplits) sink.split_environment(path, state.throughput * radiance);
  sink.escaped_event(ray, state);
}

} // namespace kindling
