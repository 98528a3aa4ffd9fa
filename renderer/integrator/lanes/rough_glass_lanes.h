// VertexLanes: rough glass, whose microfacets reflect and refract.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/bsdf/rough_glass.h"
#include "renderer/integrator/lanes/vertex_lanes.h"
#include "renderer/integrator/stages/specular_cone.h"
#include "renderer/world/ray_origins.h"

#include <array>
#include <bit>
#include <cstdint>

namespace kindling {

// The steps of PathStages::scatter_at(), as far as they concern rough glass.
template <typename Sink>
void VertexLanes<Sink>::shade_rough_glass(VertexQueue& queue) {
  const GatheredVertices v(queue, stages_, context_);
  queue.count = 0;
  const GlassBoundaries here = boundaries_at(v);
  const uint32_t light_samples = stages_.light_sample_count(*v.states[0]); // before a path leaves its first surface
  const uint32_t all = (1U << v.count) - 1U;
  const uint32_t matched = packed(is_matched(valid_eta(here.eta))) & all; // no microfacets bend light there
  for (uint32_t rest = matched; rest != 0; rest &= rest - 1) {
    const auto lane = static_cast<uint32_t>(std::countr_zero(rest));
    shade_alone(v.numbers[lane], *v.members[lane]);
  }
  const uint32_t lanes = all & ~matched;
  if (lanes == 0) return;
  const RoughGlass glass(v.parameters, here.eta, v.wo);
  const uint32_t left = leaves_environment(v, here) & lanes;
  light_glass(v, here, glass, light_samples, left, lanes);
  const RoughGlass::Drawn drawn = glass.sample(v.choice, v.direction_draws);
  const Vectors wi = v.frame.to_world(drawn.wi);
  extend_glass(v, here,
               {drawn.found, drawn.reflects, wi, drawn.weight, drawn.pdf, light_samples,
                stages_.light_paths ? is_narrow(glass, glass.eval(v.frame.to_local(wi)).pdf) : LaneMask{}, left},
               lanes);
}

// Returns what light paths find of its light: all, or nothing.
template <typename Sink>
LaneMask VertexLanes<Sink>::is_narrow(const RoughGlass& glass, const Lanes& pdf) {
  return (glass.alpha() <= LightPathView::kMaxNarrowAlpha) & (pdf > 0.0f);
}

// PathStages::leaves_environment(), with a bit for each lane.
template <typename Sink>
uint32_t VertexLanes<Sink>::leaves_environment(const GatheredVertices& v, const GlassBoundaries& here) const {
  const LaneMask follows = here.spread >= 0.0f;
  if (!any(follows)) return 0;
  uint32_t inside = 0;
  for (uint32_t lane = 0; lane < Lanes::kCount; ++lane)
    inside |= v.members[lane]->surface.layers.entering ? 0U : 1U << lane;
  const Vectors straight = -v.frame.normal;
  const Lanes spread = glass_spread(v, here, straight, straight.dot(v.normal) > 0.0f);
  return inside & packed(follows & lobe_is_covered(v.parameters.roughness, here.eta, spread, stages_.specular_scale));
}

// Adds the light samples of some lanes; those of `left` have none of the environment.
template <typename Sink>
void VertexLanes<Sink>::light_glass(const GatheredVertices& v, const GlassBoundaries& here, const RoughGlass& glass,
                                    uint32_t light_samples, uint32_t left, uint32_t lanes) {
  std::array<ShadowLanes, kMaxDirectSamples> shadows;
  shared_second_ = LaneMask{};
  for (uint32_t number = 0; number < light_samples; ++number)
    weigh_glass(v, here, glass, light_samples, number, left, lanes, shadows[number]);
  for (uint32_t rest = lanes; rest != 0; rest &= rest - 1) {
    const auto lane = static_cast<uint32_t>(std::countr_zero(rest));
    for (uint32_t number = 0; number < light_samples; ++number)
      if (((shadows[number].lit >> lane) & 1U) != 0) add_shadow(v, lane, number, shadows[number]);
  }
}

template <typename Sink>
void VertexLanes<Sink>::weigh_glass(const GatheredVertices& v, const GlassBoundaries& here, const RoughGlass& glass,
                                    uint32_t light_samples, uint32_t number, uint32_t left, uint32_t lanes,
                                    ShadowLanes& shadows) {
  const GatheredLights lights(v, context_.group, number);
  const LaneMask no{};
  const Lanes side = lights.wi.dot(v.normal);
  const Vectors local = v.frame.to_local(lights.wi);
  const RoughGlass::Eval eval = glass.eval(local);
  const uint32_t received =
      packed(((side > 0.0f) == (lights.wi.dot(v.frame.normal) > 0.0f)) & (is_black(eval.value) == no));
  shadows.lit = lanes & lights.there & ~(left & packed(lights.is_environment)) & received;
  const auto [density, weight] = PathStages::weight_of(PathStages::DirectCounts{light_samples}, lights.pdf, eval.pdf,
                                                       Lanes(0.0f), lights.is_environment, no, lights.is_delta);
  shadows.lit &= packed(density > 0.0f);
  if (shadows.lit == 0) return;
  const LaneMask below = side < 0.0f;
  const Vectors origin = origin_beside<Lanes>(v.position, v.position_error, v.normal, below);
  const WayToLight<Lanes> way = way_to_light(v.position, origin, lights.wi, lights.distance, lights.normal);
  shadows.rays = first_halves(origin, way.direction, way.length);
  shadows.contributions.store(v.throughput * eval.value * lights.radiance * Lanes(weight / density));
  const uint32_t narrow = packed(is_narrow(glass, eval.pdf));
  for (uint32_t rest = shadows.lit; rest != 0; rest &= rest - 1) {
    const auto lane = static_cast<uint32_t>(std::countr_zero(rest));
    const PathInFlight path = context_.path_at(context_.active[v.numbers[lane]]);
    const ShadeGroup::Member& member = *v.members[lane];
    const LightSample& light = *context_.group.lights[member.first_light + number];
    Rgb contribution = shadows.contributions[lane];
    if (path.state.in_medium || below[lane] != 0)
      contribution *=
          stages_.transmittance_to_light(member.surface, &here.layers[lane], side[lane], light.distance, path);
    if (stages_.light_paths && stages_.light_is_shared(member.surface, side[lane], path.state))
      contribution *= stages_.light_path_weight(member.surface, v.rays[lane]->time, light,
                                                ((narrow >> lane) & 1U) != 0 ? LightPathView::kShares : 0, path.state);
    shadows.contributions.set(lane, contribution);
  }
}

} // namespace kindling
