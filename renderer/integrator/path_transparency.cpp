// Transparency in the path tracer: paths and shadow rays through partial coverage and thin walls.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/integrator/path_integrator.h"

#include <cassert>

namespace kindling {

// Decides with the given probability whether a path passes straight through a surface.
bool PathIntegrator::passes_through(float probability, uint32_t slot, PathContext& context) const {
  assert(probability >= 0.0f && probability <= 1.0f);
  const PathState& state = context.states[slot];
  const CameraSample& sample = context.camera_samples[slot];
  const uint32_t layer = state.transparent_surfaces;
  const uint32_t key = layer == 0 ? sample.address.key : hash_combine(sample.address.key, layer);
  return Sampler::sample_1d(key, sample.address.index, state.dimension(kCoverageDimension)) >= 1.0f - probability;
}

// Coverage passes 1 - alpha of the light, a thin wall alpha times its transmittance. The density of
// the direction is unchanged: light sampling finds the same light through the thin wall
// (trace_shadows).
bool PathIntegrator::passes_through(const Vertex& vertex, PathContext& context) const {
  PathState& state = context.states[vertex.slot];
  const float alpha = vertex.surface.alpha;
  const Rgb thin_wall = vertex.bsdf.bsdf().straight_transmittance();
  if (is_black(thin_wall)) return alpha < 1.0f && passes_through(1.0f - alpha, vertex.slot, context);
  const Rgb passed = Rgb(1.0f - alpha) + thin_wall * alpha;
  const float scattered = alpha * max_component(vertex.bsdf.bsdf().albedo());
  const float probability = max_component(passed) / (max_component(passed) + scattered);
  const bool passes = passes_through(probability, vertex.slot, context);
  state.throughput *= passes ? passed / probability : Rgb(alpha / (1.0f - probability));
  return passes;
}

// Continues the same ray behind the surface. The density of its direction is unchanged.
void PathIntegrator::continue_through(const accel::Ray& ray, const SurfacePoint& surface, uint32_t slot,
                                      PathContext& context) const {
  if (++context.states[slot].transparent_surfaces > kMaxTransparentSurfaces) return;
  context.next_active.push_back(slot);
  context.next_rays.push_back(ray);
  context.next_rays.back().origin = offset_ray_origin(surface, ray.direction);
}

// Traces unoccluded shadow rays from thin wall to thin wall, all of them together, and multiplies
// their contributions by the transmittances. Hits come in order along a ray, so the product does
// not depend on batching.
void PathIntegrator::tint_shadows(PathContext& context) const {
  context.thin_wall_rays.clear();
  context.thin_wall_records.clear();
  for (size_t i = 0; i < context.shadow_rays.size(); ++i) {
    if (context.occluded[i]) continue;
    context.thin_wall_rays.push_back(context.shadow_rays[i]);
    context.thin_wall_rays.back().flags = kHitThinWalls;
    context.thin_wall_records.push_back(static_cast<uint32_t>(i));
  }
  for (uint32_t thin_wall = 0; thin_wall < kMaxTransparentSurfaces && !context.thin_wall_rays.empty(); ++thin_wall) {
    context.thin_wall_hits.resize(context.thin_wall_rays.size());
    world_.accelerator().intersect(context.thin_wall_rays, context.thin_wall_hits);
    context.counters.shadow += context.thin_wall_rays.size();
    size_t remaining = 0;
    for (size_t i = 0; i < context.thin_wall_rays.size(); ++i) {
      const accel::Hit& hit = context.thin_wall_hits[i];
      if (!hit.is_hit()) continue;
      accel::Ray ray = context.thin_wall_rays[i];
      SurfacePoint& surface = context.group.members[0].surface; // free: shading of the batch has ended
      world_.surface_at(ray, hit, surface);
      const uint32_t number = context.thin_wall_records[i];
      if (surface.unlit) context.occluded[context.thin_wall_records[i]] = 1; // no ray can leave it (WorldView::guard)
      if (!surface.layered || !surface.layers.thin_wall) continue; // the occlusion query has handled this surface
      Rgb& contribution = context.shadow_records[number].contribution;
      contribution *= thin_wall_transmittance(surface, -ray.direction);
      if (is_black(contribution)) {
        context.occluded[number] = 1;
        continue;
      }
      ray.origin = offset_ray_origin(surface, ray.direction);
      if (ray.t_max < kInfinity) ray.t_max = (ray.t_max - hit.t) * (1.0f - 1e-6f);
      if (!(ray.t_max > 0.0f)) continue;
      context.thin_wall_rays[remaining] = ray;
      context.thin_wall_records[remaining] = number;
      ++remaining;
    }
    context.thin_wall_rays.resize(remaining);
    context.thin_wall_records.resize(remaining);
  }
  for (const uint32_t number : context.thin_wall_records) context.occluded[number] = 1; // behind too many thin walls
}

Rgb PathIntegrator::thin_wall_transmittance(SurfacePoint& surface, const V3f& wo) const {
  const Frame frame = Frame::around(surface.shading_normal);
  const LayersHere layers = resolve_layers(surface, frame, PathState{}, MediumStack{}, 0.0f);
  const SurfaceBsdf bsdf(surface.bsdf, layers.parameters, frame.to_local(wo));
  return Rgb(1.0f - surface.alpha) + bsdf.straight_transmittance() * surface.alpha;
}

} // namespace kindling
