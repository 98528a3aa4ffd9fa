// The path tracer's shadow rays: whether something is in the way, and what panes leave of the light.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/integrator/path_integrator.h"
#include "renderer/integrator/path_recorder.h"

namespace kindling {

void PathIntegrator::trace_shadows(PathContext& context) const {
  const size_t count = context.shadow_rays.size();
  if (count == 0) return;
  context.occluded.resize(count);
  world_.accelerator().occluded(context.shadow_rays, context.occluded);
  context.counters.shadow += count;
  if (world_.has_panes()) tint_shadows(context);
  for (size_t i = 0; i < count; ++i) {
    if (context.occluded[i]) continue;
    if (context.recorder) context.recorder->take_light(i);
    const ShadowRecord& record = context.shadow_records[i];
    context.states[record.slot].light[record.light_class] += record.contribution;
  }
}

// Rays that nothing blocks are followed from pane to pane, all of them together, and their contributions are
// multiplied by what each lets through. Hits come in order along the ray, so the product does not depend on how it was traced.
void PathIntegrator::tint_shadows(PathContext& context) const {
  context.pane_rays.clear();
  context.pane_records.clear();
  for (size_t i = 0; i < context.shadow_rays.size(); ++i) {
    if (context.occluded[i]) continue;
    context.pane_rays.push_back(context.shadow_rays[i]);
    context.pane_rays.back().flags = kHitPanes;
    context.pane_records.push_back(static_cast<uint32_t>(i));
  }
  for (uint32_t pane = 0; pane < kMaxTransparentSurfaces && !context.pane_rays.empty(); ++pane) {
    context.pane_hits.resize(context.pane_rays.size());
    world_.accelerator().intersect(context.pane_rays, context.pane_hits);
    context.counters.shadow += context.pane_rays.size();
    size_t kept = 0;
    for (size_t i = 0; i < context.pane_rays.size(); ++i) {
      const accel::Hit& hit = context.pane_hits[i];
      if (!hit.is_hit()) continue;
      accel::Ray ray = context.pane_rays[i];
      SurfacePoint& surface = context.group.members[0].surface; // shading is done with it
      // Directions of shadow rays are unit.
      world_.surface_at(ray, hit, surface);
      const uint32_t number = context.pane_records[i];
      if (!surface.layered || !surface.layers.pane) continue; // not a pane: the first query has judged it
      Rgb& contribution = context.shadow_records[number].contribution;
      contribution *= pane_transmittance(surface, -ray.direction);
      if (is_black(contribution)) {
        context.occluded[number] = 1;
        continue;
      }
      ray.origin = offset_ray_origin(surface, ray.direction);
      if (ray.t_max < kInfinity) ray.t_max = (ray.t_max - hit.t) * (1.0f - 1e-6f);
      if (!(ray.t_max > 0.0f)) continue;
      context.pane_rays[kept] = ray;
      context.pane_records[kept] = number;
      ++kept;
    }
    context.pane_rays.resize(kept);
    context.pane_records.resize(kept);
  }
  for (const uint32_t number : context.pane_records) context.occluded[number] = 1; // more panes than are followed
}

Rgb PathIntegrator::pane_transmittance(SurfacePoint& surface, const V3f& wo) const {
  const Frame frame = Frame::around(surface.shading_normal);
  const LayersHere layers = resolve_layers(surface, frame, PathState{}, MediumStack{}, 0.0f);
  const SurfaceBsdf bsdf(surface.bsdf, layers.parameters, frame.to_local(wo));
  return Rgb(1.0f - surface.alpha) + bsdf.straight_transmittance() * surface.alpha;
}

} // namespace kindling
