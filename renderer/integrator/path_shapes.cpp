// Emission of punctual lights with a size along the path tracer's bounce rays.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/integrator/path_integrator.h"

namespace kindling {

// Adds the light of the shapes that the ray of active path `i` crosses on its way to its hit, or to
// infinity. Shapes block nothing. Camera rays do not see them, straight continuations through
// transparency included.
void PathIntegrator::add_shapes(size_t i, PathContext& context) const {
  const uint32_t slot = context.active[i];
  PathState& state = context.states[slot];
  if (state.bounce == 0) return;
  const accel::Ray& ray = context.rays[i];
  // Distances are measured from the last reflection, in front of any transparent surfaces passed
  // since.
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
  const Rgb radiance = world_.lights.shape_radiance(stretch);
  if (!is_black(radiance)) state.light[state.light_class(state.bounce)] += state.throughput * radiance;
}

} // namespace kindling
