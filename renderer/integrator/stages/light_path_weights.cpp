// Weights of paths from the camera beside light paths.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/integrator/stages/path_stages.h"

#include "renderer/integrator/stages/rest_surface.h"

#include <cassert>

namespace kindling {

namespace {

// True if no light path comes by this surface, whatever its material.
bool is_left_out(const SurfacePoint& surface, const PathState& state) {
  return surface.alpha < 1.0f || surface.has_thin_wall() || state.bounce > LightPathView::kMaxBounces;
}

bool is_boundary(const SurfacePoint& surface) { return surface.layered && surface.layers.boundary; }

// Returns the narrow share of what is scattered into a direction, in 1 / LightPathView::kShares.
uint32_t narrow_steps(const PathStages::Vertex& vertex, const V3f& wi, bool delta) {
  return LightPathView::narrow_steps(vertex.bsdf.bsdf(), vertex.frame.to_local(wi), delta);
}

// Returns the weight of light of a path from the camera, given the share of it that light paths
// find, too.
float weight_beside(float share, float ratio) { return (1.0f - share) + share * LightPathView::camera_weight(ratio); }
float weight_beside(const PathState& state, float ratio) {
  return weight_beside(LightPathView::share_of(state.first_share, state.last_share), ratio);
}

// Notes a direction, given a function that returns its narrow_steps() if the surface is a caster.
template <typename NarrowSteps>
void note_direction(const PathStages& stages, const SurfacePoint& surface, const NarrowSteps& narrow_steps_of_caster,
                    bool crosses, PathState& state) {
  const bool joins_here = state.narrow_so_far; // if it is not for the narrow lobes alone
  if (!joins_here && state.light_path_scale == 0.0f) return;
  const bool caster = stages.light_paths->is_caster(surface.material) && !is_left_out(surface, state);
  const uint32_t narrow = caster ? narrow_steps_of_caster() : 0;
  if (joins_here) {
    state.narrow_so_far = narrow == LightPathView::kShares;
    if (state.narrow_so_far) state.light_path_scale = 0.0f;
    if (state.light_path_scale == 0.0f) return;
    state.first_share = static_cast<uint8_t>(LightPathView::kShares - narrow);
  } else {
    state.last_share = static_cast<uint8_t>(narrow);
  }
  if (!is_boundary(surface) || !(stages.world->medium(surface.material).dispersion > 0.0f)) return;
  if (LightPathView::mixes_colors(crosses, state.in_medium, state.wavelength_nm != 0.0f, state.reflected_undispersed))
    state.light_path_scale = 0.0f;
  else if (state.wavelength_nm == 0.0f && !crosses)
    state.reflected_undispersed = true;
}

} // namespace

float PathStages::find_light_path_scale(const accel::Ray& ray, const accel::Hit& hit, const SurfacePoint& surface,
                                        const PathInFlight& path) const {
  PathState& state = path.state;
  if (is_boundary(surface)) {
    find_boundary_scale(surface, state);
    return 0.0f;
  }
  const float before = std::abs(state.light_path_scale);
  state.light_path_scale = 0.0f;
  if (is_left_out(surface, state)) return 0.0f;
  if (before != 0.0f) { // joined before
    state.light_path_scale = light_paths->is_caster(surface.material) ? before : -before;
    return 0.0f;
  }
  if (!state.narrow_so_far) return 0.0f;
  const bool seen_directly = state.bounce == 0 && !state.in_medium && state.transparent_surfaces == 0;
  if (seen_directly && light_paths->paths_per_pass > 0.0f) {
    const float distance = (surface.position - ray.origin).length();
    state.light_path_scale = -light_paths->ratio_scale(
        LightPathView::camera_density(*camera, ray.direction, distance, surface.geometric_normal, ray.time));
    return 0.0f;
  }
  if (!gathers_photons(path)) return 0.0f;
  const float radius2 = light_paths->photon_radius2(state.cone.width_m / sample_width, path.map_sample);
  // A cosine lobe is that many times as dense, seen from outside.
  const float eta = state.in_medium ? world->medium(*path.media.innermost()).ior : 1.0f;
  float scale = light_paths->photon_ratio_scale(radius2) * eta * eta;
  if (world->has_motion) {
    if (rest_surface(*world, surface, hit, ray.time).area_ratio == 0.0f) return 0.0f;
    scale *= 2.0f * light_paths->photon_time_span(path.map_sample);
  }
  state.light_path_scale = -scale;
  return radius2;
}

void PathStages::find_boundary_scale(const SurfacePoint& surface, PathState& state) const {
  const bool stays = light_paths->is_caster(surface.material) && !is_left_out(surface, state);
  state.light_path_scale = stays ? std::abs(state.light_path_scale) : 0.0f;
}

// Light paths enter no scattering media, and a path with a wavelength cannot be joined to one that
// may have another.
bool PathStages::gathers_photons(const PathInFlight& path) const {
  if (!(light_paths->photons_per_pass > 0.0f) || path.state.wavelength_nm != 0.0f) return false;
  return !path.state.in_medium || is_black(world->medium(*path.media.innermost()).scattering);
}

void PathStages::note_scattered(const Vertex& vertex, const GuidedBsdf::Sample& scattered, PathState& state) const {
  note_direction(
      *this, vertex.surface, [&] { return narrow_steps(vertex, scattered.wi, scattered.pdf == 0.0f); },
      scattered.cosine < 0.0f, state);
}

void PathStages::note_scattered(const SurfacePoint& surface, uint32_t narrow, bool crosses, PathState& state) const {
  note_direction(
      *this, surface, [narrow] { return narrow; }, crosses, state);
}

bool PathStages::light_is_shared(const SurfacePoint& surface, float side, const PathState& state) const {
  // At the first surface the scale is still 0: light paths have a caster.
  if (state.light_path_scale == 0.0f || !light_paths->is_caster(surface.material) || is_left_out(surface, state))
    return false;
  const bool light_in_medium = side > 0.0f ? state.in_medium : !is_boundary(surface) || surface.layers.entering;
  if (light_in_medium) return false;
  return !is_boundary(surface) || !(world->medium(surface.material).dispersion > 0.0f) ||
         !LightPathView::mixes_colors(side < 0.0f, state.in_medium, state.wavelength_nm != 0.0f,
                                      state.reflected_undispersed);
}

float PathStages::light_path_weight(const Vertex& vertex, const LightSample& light, float side,
                                    const PathState& state) const {
  if (!light_is_shared(vertex.surface, side, state)) return 1.0f;
  return light_path_weight(vertex.surface, vertex.time, light, narrow_steps(vertex, light.wi, false), state);
}

float PathStages::light_path_weight(const SurfacePoint& surface, float time, const LightSample& light, uint32_t narrow,
                                    const PathState& state) const {
  const float share = LightPathView::share_of(state.first_share, narrow);
  const float scale = std::abs(state.light_path_scale);
  const EmissionView& emission = light_paths->emission;
  const auto triangles = static_cast<uint32_t>(world->lights.triangles.size());
  const float density =
      light.kind == LightKind::environment
          ? emission.environment_density(world->lights.environment.eval(light.wi), surface.position, -light.wi)
      : light.emitter < triangles
          ? emission.triangle_density(light.emitter, surface.position + light.wi * light.distance, -light.wi,
                                      light.normal.dot(light.wi), time)
          : emission.punctual_density(light.emitter - triangles, surface.position, -light.wi, time);
  return weight_beside(share, scale * density);
}

float PathStages::emission_weight(const accel::Ray& ray, const SurfacePoint& surface, const PathState& state) const {
  if (!(state.light_path_scale > 0.0f) || state.in_medium || surface.emissive_triangle == accel::kNoId) return 1.0f;
  const float density =
      light_paths->emission.triangle_density(surface.emissive_triangle, surface.position, -ray.direction,
                                             surface.geometric_normal.dot(ray.direction), ray.time);
  return weight_beside(state, state.light_path_scale * density);
}

float PathStages::environment_weight(const accel::Ray& ray, const EnvironmentView::Location& at,
                                     const PathState& state) const {
  if (!(state.light_path_scale > 0.0f) || state.in_medium || !world->lights.has_environment) return 1.0f;
  const EnvironmentEval sky = world->lights.environment.eval(at);
  return weight_beside(state, state.light_path_scale *
                                  light_paths->emission.environment_density(sky, ray.origin, -ray.direction));
}

float PathStages::shape_weight(const accel::Ray& ray, uint32_t punctual, const PathState& state) const {
  if (!(state.light_path_scale > 0.0f) || state.in_medium) return 1.0f;
  return weight_beside(state, state.light_path_scale * light_paths->emission.punctual_density(
                                                           punctual, ray.origin, -ray.direction, ray.time));
}

void PathStages::add_shapes_beside_light_paths(const accel::Ray& ray, const accel::Hit& hit,
                                               const PathInFlight& path) const {
  PathState& state = path.state;
  world->lights.visit_shapes(shape_ray(ray, hit, path), [&](uint32_t number, const Rgb& radiance) {
    state.light[state.light_class(state.bounce)] += state.throughput * radiance * shape_weight(ray, number, state);
  });
}

} // namespace kindling
