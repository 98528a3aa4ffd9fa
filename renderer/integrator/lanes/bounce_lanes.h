// VertexLanes: the next directions.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/integrator/lanes/vertex_lanes.h"
#include "renderer/integrator/stages/sample_cone.h"
#include "renderer/integrator/stages/specular_cone.h"
#include "renderer/world/ray_origins.h"

#include <bit>
#include <cstddef>
#include <cstdint>
#include <optional>

namespace kindling {

template <typename Sink>
template <typename Bsdf>
void VertexLanes<Sink>::scatter(const GatheredVertices& v, const Bsdf& bsdf, const PathStages::DirectCounts& counts,
                                uint32_t lanes) {
  const Scattered drawn = draw(v, bsdf, lanes);
  const Vectors& wi = drawn.wi;
  const Vectors weighted = v.throughput * drawn.weight;
  const LaneMask no{};
  lanes &= packed(drawn.found & ((wi.dot(v.normal) < 0.0f) == no) & (is_black(weighted) == no));
  const Lanes so_far = guides_.guided() != 0 ? v.guiding * (drawn.pdf / drawn.bsdf_pdf) : v.guiding;
  if (prepares_ || !context_.surfaces.empty()) note_directions(v, drawn, lanes);
  // The light of a shared tail alone counts from here on, but roulette as if all did.
  const Lanes guiding = select(shared_second_, so_far * max_component(weighted), so_far);
  const Vectors before = select(shared_second_, Vectors(Lanes(1.0f)), weighted);
  const Lanes survival = survival_of(before, guiding);
  const LaneMask gambles = v.has_roulette & (shared_first_ == no);
  const Vectors throughput = select(gambles, before / survival, before);
  lanes &= packed((v.roulette < survival) | (gambles == no));
  if (lanes == 0) return;

  const Vectors origin = origin_beside<Lanes>(v.position, v.position_error, v.normal, no);
  const LaneRows rays = first_halves(origin, wi, Lanes(kInfinity));
  Lanes columns[Lanes::kCount] = {throughput.x,
                                  throughput.y,
                                  throughput.z,
                                  drawn.pdf,
                                  drawn.pdf / static_cast<float>(counts.lights),
                                  static_cast<float>(counts.reflections) * drawn.reflection_pdf / drawn.pdf,
                                  scattered_spread(v.spread, drawn.pdf),
                                  guiding};
  LaneRows states;
  states.store_columns(columns);
  const uint32_t glossy = packed(drawn.glossy);
  LaneNumbers shares; // of casters
  if ((lanes & casters_) != 0) {
    const Vectors local = v.frame.to_local(wi);
    shares = narrow_shares(bsdf, local, bsdf.eval(local).pdf);
  }
  for (uint32_t rest = lanes; rest != 0; rest &= rest - 1) {
    const auto lane = static_cast<uint32_t>(std::countr_zero(rest));
    const PathState& state = *v.states[lane];
    const Lobe lobe = ((glossy >> lane) & 1U) != 0 ? Lobe::glossy : Lobe::diffuse;
    const float* const ray = rays[lane];
    const bool narrow = lobe == Lobe::glossy && states[lane][3] > kNarrowDensity;
    const RayCone cone = narrow && stages_.follows_specular_cone(state)
                             ? specular_cone(*stages_.world, context_.hits[v.numbers[lane]], v.members[lane]->surface,
                                             V3f(ray[4], ray[5], ray[6]), 1.0f, state.specular_cone)
                             : kNoSpecularCone;
    if (stages_.light_paths) {
      const uint32_t narrow_steps = ((casters_ >> lane) & 1U) != 0 ? LightPathView::steps_of(shares[lane]) : 0;
      stages_.note_scattered(v.members[lane]->surface, narrow_steps, false, *v.states[lane]);
    }
    extend(v, lane, ray, states[lane], lobe, cone);
  }
}

template <typename Sink>
template <typename Bsdf>
typename VertexLanes<Sink>::Scattered VertexLanes<Sink>::draw(const GatheredVertices& v, const Bsdf& bsdf,
                                                              uint32_t lanes) const {
  LaneNumbers choice;
  choice.store(v.choice);
  LaneVectors from_guide;
  uint32_t guided = lanes & guides_.guided(), followed = 0, lost = 0; // followed: they have a direction of the guide
  for (uint32_t rest = guided; rest != 0; rest &= rest - 1) {
    const auto lane = static_cast<uint32_t>(std::countr_zero(rest));
    const GuideMixture& guide = guides_[lane];
    if (!guide.selects_guide(choice[lane])) {
      choice[lane] = guide.left_to_bsdf(choice[lane]);
      continue;
    }
    const V2f u(v.direction_draws.x[lane], v.direction_draws.y[lane]);
    const std::optional<V3f> wi = guide.sample(choice[lane], u, lane_of(v.frame.normal, lane));
    (wi ? followed : lost) |= 1U << lane;
    from_guide.set(lane, wi.value_or(V3f(0.0f, 0.0f, 1.0f)));
  }
  const auto drawn = bsdf.draw(choice.load(), v.direction_draws);
  Scattered result{drawn.found, drawn.glossy, v.frame.to_world(drawn.wi), drawn.weight,
                   drawn.pdf,   drawn.pdf,    drawn.reflection_pdf};
  guided &= ~(followed | lost);
  if (guided != 0) {
    result.pdf = guides_.mixed(drawn.pdf, drawn.wi.z, result.wi, guided & packed(drawn.found));
    result.weight = select(lane_mask(guided), Vectors(drawn.weight * Lanes(drawn.pdf / result.pdf)), drawn.weight);
  }
  if (lost != 0) result.found &= lane_mask(~lost);
  if (followed != 0) follow(v, bsdf, from_guide.load(), followed, result);
  return result;
}

template <typename Sink>
template <typename Bsdf>
void VertexLanes<Sink>::follow(const GatheredVertices& v, const Bsdf& bsdf, const Vectors& wi, uint32_t lanes,
                               Scattered& result) const {
  const Vectors local = v.frame.to_local(wi);
  const BsdfEvalOf<Lanes> eval = bsdf.eval(local);
  const LaneMask found = (is_black(eval.value) == LaneMask{}) & (eval.pdf > 0.0f);
  const Lanes pdf = guides_.mixed(eval.pdf, local.z, wi, lanes & packed(found));
  LaneMask glossy{};
  for (uint32_t rest = lanes & packed(found); rest != 0; rest &= rest - 1) {
    const auto lane = static_cast<uint32_t>(std::countr_zero(rest));
    const V2f u(v.direction_draws.x[lane], v.direction_draws.y[lane]);
    glossy[lane] = guides_[lane].lobe_of(eval.pdf[lane], local.z[lane], u) == Lobe::glossy ? -1 : 0;
  }
  const LaneMask here = lane_mask(lanes);
  result.found = here ? found : result.found;
  result.glossy = here ? glossy : result.glossy;
  result.wi = select(here, wi, result.wi);
  result.weight = select(here, eval.value * Lanes(1.0f / pdf), result.weight);
  result.pdf = select(here, pdf, result.pdf);
  result.bsdf_pdf = select(here, eval.pdf, result.bsdf_pdf);
  result.reflection_pdf = select(here, eval.reflection_pdf, result.reflection_pdf);
}

template <typename Sink>
void VertexLanes<Sink>::note_directions(const GatheredVertices& v, const Scattered& drawn, uint32_t lanes) {
  for (uint32_t rest = lanes; rest != 0; rest &= rest - 1) {
    const auto lane = static_cast<uint32_t>(std::countr_zero(rest));
    const PathInFlight path = context_.path_at(context_.active[v.numbers[lane]]);
    if (path.surface && drawn.glossy[lane] == 0) path.surface->guide_found = true;
    ReusedPath* const reused = reused_[lane];
    if (!reused) continue;
    if (path.state.bounce == 0) {
      reused->value = lane_of(drawn.weight, lane) * drawn.pdf[lane];
      reused->pdf = drawn.pdf[lane];
    } else {
      reused->tail_wi = lane_of(drawn.wi, lane);
      reused->tail_pdf = drawn.pdf[lane];
    }
  }
}

template <typename Sink>
void VertexLanes<Sink>::extend(const GatheredVertices& v, uint32_t lane, const float* ray, const float* scattered,
                               Lobe lobe, const RayCone& specular_cone) {
  const PathInFlight path = context_.path_at(context_.active[v.numbers[lane]]);
  PathState& state = path.state;
  const SurfacePoint& surface = v.members[lane]->surface;
  const uint32_t key = ray_key(path.sample, state.dimension(kDirectionDimension));
  const V3f wi(ray[4], ray[5], ray[6]);
  const float pdf = scattered[3];
  state.throughput = Rgb(scattered[0], scattered[1], scattered[2]);
  state.guiding = scattered[7];
  state.emission_only = !stages_.count_bounce(lobe, pdf, state);
  if (stages_.settings.caustics == Caustics::regularized) state.widest_lobe.add(lobe, surface.bsdf.roughness);
  state.cone.spread = scattered[6];
  state.specular_cone = specular_cone;
  state.environment_left = false;
  state.bsdf_pdf = scattered[4];
  state.reflection_ratio = scattered[5];
  state.previous_position = surface.position;
  state.previous_normal = surface.light_normal();
  state.light_probabilities = v.members[lane]->sampled.light_probabilities;
  state.transparent_surfaces = 0;
  accel::Ray next = ray_of(ray, key, v.rays[lane]->time, path.sample.address.index, kHitPartlyTransparent);
  if (surface.guarded) [[unlikely]]
    next.origin = offset_ray_origin(surface, wi);
  sink_.extend(path, next);
}

} // namespace kindling
