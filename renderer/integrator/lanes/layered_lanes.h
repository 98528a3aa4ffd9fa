// VertexLanes: opaque surfaces with a coat, a sheen or anisotropic microfacets.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/bsdf/layered_bsdf.h"
#include "renderer/integrator/lanes/vertex_lanes.h"

#include <cstddef>
#include <cstdint>

namespace kindling {

// Surfaces whose light samples would be added one by one are shaded alone altogether.
template <typename Sink>
bool VertexLanes<Sink>::are_layers_in_lanes(size_t number, const SurfacePoint& surface) const {
  const uint32_t slot = context_.active[number];
  return !lights_alone_ && !surface.layers.boundary && is_opaque_without_film(surface.layers.bsdf) &&
         surface.alpha == 1.0f && !surface.guarded && !context_.states[slot].in_medium && !records_surface(slot);
}

template <typename Sink>
void VertexLanes<Sink>::shade_layers(VertexQueue& queue) {
  GatheredVertices v(queue, stages_, context_);
  queue.count = 0;
  v.turn_to_tangents();
  for (uint32_t lane = 0; lane < Lanes::kCount; ++lane) {
    const PathInFlight path = context_.path_at(context_.active[v.numbers[lane]]);
    ShadeGroup::Member& member = *v.members[lane];
    layers_here_[lane] = stages_.resolve_layers(member.surface, frame_of(v, lane), path.state, path.media,
                                                member.sampled.draws.choice.x);
  }
  shade(v, LayersBsdf(v.parameters, v.layers(), v.wo), 0);
}

} // namespace kindling
