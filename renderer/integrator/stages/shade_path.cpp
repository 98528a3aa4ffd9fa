// Steps of shading one path that need no sink.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/bsdf/bsdf_ranges.h"
#include "renderer/integrator/stages/path_stages.h"
#include "renderer/sampling/mis.h"

namespace kindling {

namespace {

// Denoisers are guided through surfaces that show others sharply and have little else of their own.
// Cycles follows microfacets up to an alpha of .075; what these show is blurred and made the guides
// of a car in the sun noisy (renderer/denoise/README.md).
constexpr float kMaxSmoothAlpha = 0.01f;
constexpr float kMinSmoothShare = 0.75f;

} // namespace

ShapeRay PathStages::shape_ray(const accel::Ray& ray, const accel::Hit& hit, const PathInFlight& path) const {
  const PathState& state = path.state;
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
  return stretch;
}

void PathStages::add_shapes_alone(const accel::Ray& ray, const accel::Hit& hit, const PathInFlight& path) const {
  PathState& state = path.state;
  const Rgb radiance = world->lights.shape_radiance(shape_ray(ray, hit, path));
  if (!is_black(radiance)) state.light[state.light_class(state.bounce)] += state.throughput * radiance;
}

void PathStages::regularize(SurfacePoint& surface, const PathState& state, uint32_t sample_index) const {
  const bool after_diffuse = state.diffuse_bounces() > 0;
  if (surface.layered)
    regularize_caustics(settings.caustics, after_diffuse, state.widest_lobe, sample_index, surface.layers.thin_wall,
                        surface.bsdf, surface.layers.bsdf);
  else
    regularize_caustics(settings.caustics, after_diffuse, state.widest_lobe, sample_index, surface.bsdf);
}

Rgb PathStages::light_of_emission(const accel::Ray& ray, const SurfacePoint& surface, float beside,
                                  const PathState& state) const {
  float weight = 1.0f;
  if (state.bsdf_pdf > 0.0f && surface.emissive_triangle != accel::kNoId) {
    const float distance = (surface.position - state.previous_position).length();
    weight =
        power_heuristic(state.bsdf_pdf, world->lights.pdf_triangle(surface.emissive_triangle, state.previous_position,
                                                                   state.previous_normal, ray.direction, distance,
                                                                   state.light_probabilities, ray.time));
  }
  return state.throughput * surface.emitted * (surface.alpha * (weight * beside));
}

void PathStages::record_surface(const accel::Ray& ray, const SurfacePoint& surface, const SurfaceBsdf* bsdf,
                                const PathState& state, FilmSurface& record) const {
  const Rgb albedo = bsdf ? bsdf->albedo() : surface.emitted;
  if (state.bounce == 0) {
    record.hit = true;
    record.albedo = albedo;
    record.normal = surface.shading_normal;
    record.depth = camera->depth(surface.position, ray.time);
    record.position = surface.position;
  }
  if (!record.hit || record.guide_found) return;
  record.guide_albedo = saturate(state.throughput * albedo);
  record.guide_normal = surface.shading_normal;
  record.guide_found = !bsdf || bsdf->smooth_share(kMaxSmoothAlpha) < kMinSmoothShare;
}

} // namespace kindling
