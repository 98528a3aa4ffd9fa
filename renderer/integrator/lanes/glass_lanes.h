// VertexLanes: clear glass, which reflects and refracts into exact directions.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/bsdf/clear_glass.h"
#include "renderer/integrator/lanes/vertex_lanes.h"
#include "renderer/integrator/stages/specular_cone.h"
#include "renderer/world/curvature.h"
#include "renderer/world/ray_origins.h"

#include <bit>
#include <cstddef>
#include <cstdint>

namespace kindling {

// Nothing samples lights there, guides directions or shares paths, so only the next direction is
// left to choose.
template <typename Sink>
bool VertexLanes<Sink>::is_glass_in_lanes(size_t number, const SurfacePoint& surface) const {
  const LayerParameters& layers = surface.layers.bsdf;
  const bool has_film = layers.iridescence > 0.0f && layers.iridescence_thickness_nm > 0.0f;
  return !is_alone_ && !stages_.samples_light(surface) && !has_film && surface.alpha == 1.0f &&
         !records_surface(context_.active[number]);
}

// Returns the spread of the specular cones; below 0 where there are none.
template <typename Sink>
Lanes VertexLanes<Sink>::glass_spread(const GatheredVertices& v, const Vectors& wi, const LaneMask& reflected,
                                      const Lanes& eta) const {
  GatheredVertices::Each<const accel::Hit*> hits;
  LaneNumbers widths, spreads;
  bool any_follows = false;
  for (uint32_t lane = 0; lane < Lanes::kCount; ++lane) {
    const PathState& state = *v.states[lane];
    const bool follows = stages_.follows_specular_cone(state);
    hits[lane] = &context_.hits[v.numbers[lane]];
    widths[lane] = state.specular_cone.width_m;
    spreads[lane] = follows ? state.specular_cone.spread : -1.0f;
    any_follows |= follows;
  }
  const Lanes arriving = spreads.load();
  if (!any_follows) return arriving;
  const Lanes bend = curvature_at(*stages_.world, hits) * widths.load();
  const Lanes cosine = absolute(wi.dot(v.frame.normal));
  return select(arriving < 0.0f, arriving, spread_beyond(arriving, bend, cosine, reflected, eta));
}

// The steps of PathStages::scatter_at(), as far as they concern clear glass.
template <typename Sink>
void VertexLanes<Sink>::shade_glass(VertexQueue& queue) {
  const GatheredVertices v(queue, stages_, context_);
  queue.count = 0;
  GatheredVertices::Each<PathStages::LayersHere> layers;
  LaneNumbers eta, odds;
  for (uint32_t lane = 0; lane < v.count; ++lane) {
    const PathInFlight path = context_.path_at(context_.active[v.numbers[lane]]);
    ShadeGroup::Member& member = *v.members[lane];
    SurfacePoint& surface = member.surface;
    layers[lane] = stages_.resolve_media(surface, path.state, path.media, member.sampled.draws.choice.x);
    eta[lane] = surface.layers.bsdf.eta;
    odds[lane] = stages_.favors_reflection(surface, path.state) ? stages_.reflection_odds(*member.sampled.mirrored) : 1;
    if (stages_.light_paths) stages_.find_boundary_scale(surface, path.state);
  }
  for (uint32_t lane = v.count; lane < Lanes::kCount; ++lane) eta[lane] = odds[lane] = 1.0f;
  const auto drawn = ClearGlassOf<Lanes>(v.parameters, eta.load(), odds.load(), v.wo).sample(v.choice);
  const Vectors wi = v.frame.to_world(drawn.wi);
  const Vectors weighted = v.throughput * drawn.weight;
  const LaneMask no{};
  const LaneMask below = wi.dot(v.normal) < 0.0f;
  const LaneMask crosses = drawn.reflects == no;
  const Lanes survival = survival_of(weighted, v.guiding);
  const uint32_t lanes = packed(drawn.found & (below == crosses) & (is_black(weighted) == no) &
                                ((v.roulette < survival) | (v.has_roulette == no))) &
                         ((1U << v.count) - 1U);
  const Vectors throughput = select(v.has_roulette, weighted / survival, weighted);
  const LaneRows rays =
      first_halves(origin_beside<Lanes>(v.position, v.position_error, v.normal, below), wi, Lanes(kInfinity));
  Lanes columns[Lanes::kCount] = {throughput.x, throughput.y, throughput.z, 0.0f, 0.0f, 0.0f, v.spread, v.guiding};
  LaneRows states;
  states.store_columns(columns);
  LaneNumbers spreads;
  spreads.store(glass_spread(v, wi, drawn.reflects, eta.load()));
  const uint32_t crossing = packed(crosses);
  for (uint32_t rest = lanes; rest != 0; rest &= rest - 1) {
    const auto lane = static_cast<uint32_t>(std::countr_zero(rest));
    const bool leaves = ((crossing >> lane) & 1U) != 0; // to the other side
    const PathInFlight path = context_.path_at(context_.active[v.numbers[lane]]);
    const SurfacePoint& surface = v.members[lane]->surface;
    if (stages_.light_paths) stages_.note_clear(surface, leaves, path.state);
    const RayCone cone =
        spreads[lane] < 0.0f ? kNoSpecularCone : RayCone{path.state.specular_cone.width_m, spreads[lane]};
    extend(v, lane, rays[lane], states[lane], leaves ? Lobe::transmission : Lobe::glossy, cone);
    if (leaves) PathStages::cross_boundary(surface, layers[lane], path.state, path.media);
  }
}

} // namespace kindling
