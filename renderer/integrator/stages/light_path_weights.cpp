// Weights of paths from the camera beside light paths. Devices trace no light paths.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/integrator/stages/path_stages.h"

namespace kindling {

namespace {

// True if no light path comes by this vertex, whatever its material.
bool is_left_out(const PathStages::Vertex& vertex, const PathState& state) {
  return vertex.surface.alpha < 1.0f || vertex.surface.has_thin_wall() || state.bounce > LightPathView::kMaxBounces ||
         (vertex.layers && vertex.layers->wavelength_nm != 0.0f);
}

} // namespace

float PathStages::light_path_scale(const accel::Ray& ray, const Vertex& vertex, const PathState& state) const {
  const SurfacePoint& surface = vertex.surface;
  if (is_left_out(vertex, state)) return 0.0f;
  const bool caster = light_paths->is_caster(surface.material);
  if (!caster && surface.layered && surface.layers.boundary) return 0.0f;
  if (state.bounce > 0) return caster ? std::abs(state.light_path_scale) : -std::abs(state.light_path_scale);
  if (caster || state.in_medium || state.transparent_surfaces > 0) return 0.0f;
  const float distance = (surface.position - ray.origin).length();
  return -light_paths->ratio_scale(
      LightPathView::camera_density(*camera, ray.direction, distance, surface.geometric_normal));
}

float PathStages::light_path_weight(const Vertex& vertex, const LightSample& light, float side,
                                    const PathState& state) const {
  const SurfacePoint& surface = vertex.surface;
  // At the first surface the scale is still 0: light paths have a caster.
  if (state.light_path_scale == 0.0f || !light_paths->is_caster(surface.material) || is_left_out(vertex, state))
    return 1.0f;
  const bool light_in_medium =
      side > 0.0f ? state.in_medium : !surface.layered || !surface.layers.boundary || surface.layers.entering;
  if (light_in_medium) return 1.0f;
  const float scale = std::abs(state.light_path_scale);
  const EmissionView& emission = light_paths->emission;
  const auto triangles = static_cast<uint32_t>(world->lights.triangles.size());
  const float density =
      light.kind == LightKind::environment
          ? emission.environment_density(world->lights.environment.eval(light.wi), surface.position, -light.wi)
      : light.emitter < triangles
          ? emission.triangle_density(light.emitter, vertex.surface.position + light.wi * light.distance, -light.wi,
                                      light.normal.dot(light.wi))
          : emission.punctual_density(light.emitter - triangles, vertex.surface.position, -light.wi);
  return LightPathView::camera_weight(scale * density);
}

float PathStages::emission_weight(const accel::Ray& ray, const SurfacePoint& surface, const PathState& state) const {
  if (!(state.light_path_scale > 0.0f) || state.in_medium || surface.emissive_triangle == accel::kNoId) return 1.0f;
  const float density = light_paths->emission.triangle_density(
      surface.emissive_triangle, surface.position, -ray.direction, surface.geometric_normal.dot(ray.direction));
  return LightPathView::camera_weight(state.light_path_scale * density);
}

float PathStages::environment_weight(const accel::Ray& ray, const EnvironmentView::Location& at,
                                     const PathState& state) const {
  if (!(state.light_path_scale > 0.0f) || state.in_medium || !world->lights.has_environment) return 1.0f;
  const EnvironmentEval sky = world->lights.environment.eval(at);
  return LightPathView::camera_weight(state.light_path_scale *
                                      light_paths->emission.environment_density(sky, ray.origin, -ray.direction));
}

void PathStages::add_shapes_beside_light_paths(const accel::Ray& ray, const accel::Hit& hit,
                                               const PathInFlight& path) const {
  PathState& state = path.state;
  world->lights.visit_shapes(shape_ray(ray, hit, path), [&](uint32_t number, const Rgb& radiance) {
    float weight = 1.0f;
    if (!state.in_medium)
      weight = LightPathView::camera_weight(state.light_path_scale *
                                            light_paths->emission.punctual_density(number, ray.origin, -ray.direction));
    state.light[state.light_class(state.bounce)] += state.throughput * radiance * weight;
  });
}

} // namespace kindling
