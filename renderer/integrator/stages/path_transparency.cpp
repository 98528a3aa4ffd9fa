// Transparency of one path and of its shadow rays: partial coverage and thin walls.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/integrator/stages/path_stages.h"

#include <cassert>

namespace kindling {

// Decides with the given probability whether a path passes straight through a surface.
bool PathStages::passes_through(float probability, const PathInFlight& path) {
  assert(probability >= 0.0f && probability <= 1.0f);
  const SampleAddress& address = path.sample.address;
  const uint32_t layer = path.state.transparent_surfaces;
  const uint32_t key = layer == 0 ? address.key : hash_combine(address.key, layer);
  return Sampler::sample_1d(key, address.index, path.state.dimension(kCoverageDimension)) >= 1.0f - probability;
}

// Coverage passes 1 - alpha of the light, a thin wall alpha times its transmittance. The density of
// the direction is unchanged: light sampling finds the same light through the thin wall
// (pass_thin_wall).
bool PathStages::passes_through(const Vertex& vertex, const PathInFlight& path) {
  const float alpha = vertex.surface.alpha;
  const Rgb thin_wall = vertex.bsdf.bsdf().straight_transmittance();
  if (is_black(thin_wall)) return alpha < 1.0f && passes_through(1.0f - alpha, path);
  const Rgb passed = Rgb(1.0f - alpha) + thin_wall * alpha;
  const float scattered = alpha * max_component(vertex.bsdf.bsdf().albedo());
  const float reflects = scattered / (max_component(passed) + scattered);
  const float probability = 1.0f - favored(reflects, vertex.surface.layers.bsdf.reflection_odds);
  const bool passes = passes_through(probability, path);
  path.state.throughput *= passes ? passed / probability : Rgb(alpha / (1.0f - probability));
  return passes;
}

PathStages::ThinWall PathStages::pass_thin_wall(const accel::Hit& hit, accel::Ray& ray, SurfacePoint& scratch,
                                                Rgb& contribution) const {
  world->surface_at(ray, hit, scratch);
  if (scratch.unlit) return ThinWall::blocks;                               // no ray can leave it (WorldView::guard)
  if (!scratch.layered || !scratch.layers.thin_wall) return ThinWall::last; // the occlusion query has handled it
  contribution *= thin_wall_transmittance(scratch, -ray.direction);
  if (is_black(contribution)) return ThinWall::blocks;
  ray.origin = offset_ray_origin(scratch, ray.direction);
  if (ray.t_max < kInfinity) ray.t_max = (ray.t_max - hit.t) * (1.0f - 1e-6f);
  return ray.t_max > 0.0f ? ThinWall::passed : ThinWall::last;
}

Rgb PathStages::thin_wall_transmittance(SurfacePoint& surface, const V3f& wo) const {
  const Frame frame = Frame::around(surface.shading_normal);
  const LayersHere layers = resolve_layers(surface, frame, PathState{}, MediumStack{}, 0.0f);
  const SurfaceBsdf bsdf(surface.bsdf, layers.parameters, frame.to_local(wo));
  return Rgb(1.0f - surface.alpha) + bsdf.straight_transmittance() * surface.alpha;
}

} // namespace kindling
