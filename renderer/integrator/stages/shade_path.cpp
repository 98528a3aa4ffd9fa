// Steps of shading one path that need no sink.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/integrator/stages/path_stages.h"
#include "renderer/sampling/mis.h"

namespace kindling {

void PathStages::add_shapes(const accel::Ray& ray, const accel::Hit& hit, const PathInFlight& path) const {
  PathState& state = path.state;
  if (state.bounce == 0) return;
  // Distances are measured from the last reflection, in front of any transparent surfaces passed
  // since.
  const float origin = (ray.origin - state.previous_position).dot(ray.direction);
  ShapeRay stretch{.origin = state.previous_position,
                   .normal = state.previous_normal,
                   .direction = ray.direction,
                   .begin_m = state.transparent_surfaces == 0 ? 0.0f : origin,
                   .end_m = hit.is_hit() ? origin + hit.t : kInfinity,
                   .bsdf_pdf = state.bsdf_pdf,
                   .learned = state.light_probabilities,
                   .time = ray.time};
  if (state.in_medium) stretch.extinction = world->medium(*path.media.innermost()).extinction;
  const Rgb radiance = world->lights.shape_radiance(stretch);
  if (!is_black(radiance)) state.light[state.light_class(state.bounce)] += state.throughput * radiance;
}

void PathStages::regularize(SurfacePoint& surface, const PathState& state, uint32_t sample_index) const {
  const bool after_diffuse = state.diffuse_bounces > 0;
  if (surface.layered)
    regularize_caustics(settings.caustics, after_diffuse, state.widest_lobe, sample_index, surface.layers.thin_wall,
                        surface.bsdf, surface.layers.bsdf);
  else
    regularize_caustics(settings.caustics, after_diffuse, state.widest_lobe, sample_index, surface.bsdf);
}

void PathStages::add_emission(const accel::Ray& ray, const SurfacePoint& surface, PathState& state) const {
  float weight = 1.0f;
  if (state.bsdf_pdf > 0.0f && surface.emissive_triangle != accel::kNoId) {
    const float distance = (surface.position - state.previous_position).length();
    weight =
        power_heuristic(state.bsdf_pdf, world->lights.pdf_triangle(surface.emissive_triangle, state.previous_position,
                                                                   state.previous_normal, ray.direction, distance,
                                                                   state.light_probabilities, ray.time));
  }
  state.light[state.light_class(state.bounce)] += state.throughput * surface.emitted * (surface.alpha * weight);
}

void PathStages::record_surface(const accel::Ray& ray, const SurfacePoint& surface, const SurfaceBsdf* bsdf,
                                FilmSurface& record) const {
  record.hit = true;
  record.albedo = bsdf ? bsdf->albedo() : surface.emitted;
  record.normal = surface.shading_normal;
  record.depth = camera->depth(surface.position, ray.time);
  record.position = surface.position;
}

} // namespace kindling
