// VertexLanes: clear glass, and the next rays at any glass.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/bsdf/clear_glass.h"
#include "renderer/integrator/lanes/vertex_lanes.h"
#include "renderer/integrator/stages/light_path_view.h"
#include "renderer/integrator/stages/sample_cone.h"
#include "renderer/integrator/stages/specular_cone.h"
#include "renderer/world/curvature.h"
#include "renderer/world/ray_origins.h"

#include <bit>
#include <cstddef>
#include <cstdint>

namespace kindling {

// Nothing guides directions or shares paths there; at clear glass nothing samples lights, either.
template <typename Sink>
bool VertexLanes<Sink>::is_glass_in_lanes(size_t number, const SurfacePoint& surface) const {
  const LayerParameters& layers = surface.layers.bsdf;
  const bool has_film = layers.iridescence > 0.0f && layers.iridescence_thickness_nm > 0.0f;
  return !is_alone_ && surface.layers.boundary && is_bare_glass(surface.bsdf, layers) && !has_film &&
         surface.alpha == 1.0f && !records_surface(context_.active[number]);
}

template <typename Sink>
bool VertexLanes<Sink>::take_glass(size_t number, ShadeGroup::Member& member) {
  if (!stages_.samples_light(member.surface)) {
    clear_glass_.add(number, member);
    if (clear_glass_.count == Lanes::kCount) shade_glass(clear_glass_);
    return true;
  }
  if (lights_alone_ || member.surface.guarded || !is_rough_glass(member.surface.bsdf, member.surface.layers.bsdf))
    return false;
  VertexQueue& queue = rough_glass_[context_.states[context_.active[number]].bounce == 0 ? 1 : 0];
  queue.add(number, member);
  if (queue.count == Lanes::kCount) shade_rough_glass(queue);
  return true;
}

// Completes the layers of all surfaces, by the media on both sides.
template <typename Sink>
GlassBoundaries VertexLanes<Sink>::boundaries_at(const GatheredVertices& v) const {
  GlassBoundaries here;
  GatheredVertices::Each<const accel::Hit*> hits;
  LaneNumbers eta, widths, spreads;
  bool any_follows = false;
  for (uint32_t lane = 0; lane < Lanes::kCount; ++lane) {
    const PathInFlight path = context_.path_at(context_.active[v.numbers[lane]]);
    ShadeGroup::Member& member = *v.members[lane];
    here.layers[lane] = stages_.resolve_media(member.surface, path.state, path.media, member.sampled.draws.choice.x);
    eta[lane] = member.surface.layers.bsdf.eta;
    const bool follows = stages_.follows_specular_cone(path.state);
    hits[lane] = &context_.hits[v.numbers[lane]];
    widths[lane] = path.state.specular_cone.width_m;
    spreads[lane] = follows ? path.state.specular_cone.spread : -1.0f;
    any_follows |= follows;
  }
  here.eta = eta.load();
  here.spread = spreads.load();
  here.bend = any_follows ? curvature_at(*stages_.world, hits) * widths.load() : Lanes(0.0f);
  return here;
}

// Returns the spread of the specular cones after a bounce into these directions; below 0 where
// there are none.
template <typename Sink>
Lanes VertexLanes<Sink>::glass_spread(const GatheredVertices& v, const GlassBoundaries& here, const Vectors& wi,
                                      const LaneMask& reflected) const {
  const Lanes cosine = absolute(wi.dot(v.frame.normal));
  return select(here.spread < 0.0f, here.spread, spread_beyond(here.spread, here.bend, cosine, reflected, here.eta));
}

// The steps of PathStages::scatter_at(), as far as they concern clear glass.
template <typename Sink>
void VertexLanes<Sink>::shade_glass(VertexQueue& queue) {
  const GatheredVertices v(queue, stages_, context_);
  queue.count = 0;
  const GlassBoundaries here = boundaries_at(v);
  LaneNumbers odds;
  for (uint32_t lane = 0; lane < Lanes::kCount; ++lane) {
    const ShadeGroup::Member& member = *v.members[lane];
    const PathState& state = *v.states[lane];
    odds[lane] =
        stages_.favors_reflection(member.surface, state) ? stages_.reflection_odds(*member.sampled.mirrored) : 1;
  }
  const auto drawn = ClearGlassOf<Lanes>(v.parameters, here.eta, odds.load(), v.wo).sample(v.choice);
  const GlassBounce bounce{
      drawn.found, drawn.reflects, v.frame.to_world(drawn.wi), drawn.weight, 0.0f, 1, LaneMask{} == 0, 0};
  extend_glass(v, here, bounce, (1U << v.count) - 1U);
}

// Continues the paths of some lanes.
template <typename Sink>
void VertexLanes<Sink>::extend_glass(const GatheredVertices& v, const GlassBoundaries& here, const GlassBounce& bounce,
                                     uint32_t lanes) {
  const Vectors& wi = bounce.wi;
  const Vectors weighted = v.throughput * bounce.weight;
  const LaneMask no{};
  const LaneMask below = wi.dot(v.normal) < 0.0f;
  const LaneMask crosses = bounce.reflects == no;
  const Lanes survival = survival_of(weighted, v.guiding);
  lanes &= packed(bounce.found & (below == crosses) & (is_black(weighted) == no) &
                  ((v.roulette < survival) | (v.has_roulette == no)));
  const Vectors throughput = select(v.has_roulette, weighted / survival, weighted);
  const LaneRows rays =
      first_halves(origin_beside<Lanes>(v.position, v.position_error, v.normal, below), wi, Lanes(kInfinity));
  const LaneMask exact = bounce.pdf == 0.0f;
  Lanes columns[Lanes::kCount] = {throughput.x,
                                  throughput.y,
                                  throughput.z,
                                  bounce.pdf,
                                  bounce.pdf / static_cast<float>(bounce.light_samples),
                                  0.0f,
                                  select(exact, v.spread, scattered_spread(v.spread, bounce.pdf)),
                                  v.guiding};
  LaneRows states;
  states.store_columns(columns);
  LaneNumbers spreads;
  spreads.store(glass_spread(v, here, wi, below == no));
  const uint32_t crossing = packed(crosses), narrow = packed(bounce.narrow);
  for (uint32_t rest = lanes; rest != 0; rest &= rest - 1) {
    const auto lane = static_cast<uint32_t>(std::countr_zero(rest));
    const bool leaves = ((crossing >> lane) & 1U) != 0; // to the other side
    const PathInFlight path = context_.path_at(context_.active[v.numbers[lane]]);
    const SurfacePoint& surface = v.members[lane]->surface;
    if (stages_.light_paths) {
      stages_.find_boundary_scale(surface, path.state);
      stages_.note_scattered(surface, ((narrow >> lane) & 1U) != 0 ? LightPathView::kShares : 0, leaves, path.state);
    }
    const RayCone cone =
        spreads[lane] < 0.0f ? kNoSpecularCone : RayCone{path.state.specular_cone.width_m, spreads[lane]};
    extend(v, lane, rays[lane], states[lane], leaves ? Lobe::transmission : Lobe::glossy, cone);
    path.state.environment_left = ((bounce.environment_left >> lane) & 1U) != 0;
    if (leaves) PathStages::cross_boundary(surface, here.layers[lane], path.state, path.media);
  }
}

} // namespace kindling
