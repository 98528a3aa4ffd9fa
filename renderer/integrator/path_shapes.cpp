// Bounce rays of the path tracer and the point, spot and directional lights that have a size.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/integrator/path_integrator.h"

namespace kindling {

// What the ray of active path `i` meets on its way to its hit, or away. The lights block nothing, so that the path goes on; camera rays
// see none of them (bounce 0, straight passages included).
void PathIntegrator::add_shapes(size_t i, PathContext& context) const {
  const uint32_t slot = context.active[i];
  PathState& state = context.states[slot];
  if (state.bounce == 0) return;
  const accel::Ray& ray = context.rays[i];
  // Distances count from where the direction was chosen, in front of any passages.
  const float origin = (ray.origin - state.previous_position).dot(ray.direction);
  ShapeRay stretch{.origin = state.previous_position,
                   .normal = state.previous_normal,
                   .direction = ray.direction,
                   .begin_m = state.transparent_surfaces == 0 ? 0.0f : origin,
                   .end_m = context.hits[i].is_hit() ? origin + context.hits[i].t : kInfinity,
                   .bsdf_pdf = state.bsdf_pdf,
                   .learned = state.light_probabilities,
                   .time = ray.time};
  if (state.in_medium) stretch.extinction = world_.medium(*context.media[slot].innermost()).extinction;
  const Rgb radiance = world_.lights().shape_radiance(stretch);
  if (!is_black(radiance)) state.light[state.light_class(state.bounce)] += state.throughput * radiance;
}

} // namespace kindling
