// VertexLanes: light samples and reflection samples.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/integrator/lanes/vertex_lanes.h"
#include "renderer/world/ray_origins.h"

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>

namespace kindling {

template <typename Sink>
template <typename Bsdf>
PathStages::DirectCounts VertexLanes<Sink>::counts_of(const PathState& state, const Bsdf& bsdf) const {
  const bool reflects = state.bounce == 0 && stages_.world->lights.has_environment && any(bsdf.has_microfacets());
  return {stages_.light_sample_count(state), reflects ? static_cast<uint32_t>(stages_.settings.reflection_samples) : 0};
}

template <typename Sink>
template <typename Bsdf>
void VertexLanes<Sink>::add_lights(const GatheredVertices& v, const Bsdf& bsdf, const PathStages::DirectCounts& counts,
                                   uint32_t lanes) {
  std::array<ShadowLanes, kMaxDirectSamples + kMaxReflectionSamples> shadows;
  uint32_t count = 0;
  for (; count < counts.lights; ++count)
    weigh(v, bsdf, counts, GatheredLights(v, context_.group, count), count, false, lanes, shadows[count]);
  if (counts.reflections > 0) {
    LaneNumbers probabilities; // of light samples to choose the environment
    for (uint32_t lane = 0; lane < v.count; ++lane) {
      const ShadeGroup::Member& member = *v.members[lane];
      probabilities[lane] = stages_.world->lights.environment_probability(
          member.surface.position, member.surface.geometric_normal, member.sampled.light_probabilities);
    }
    for (uint32_t number = 0; number < counts.reflections; ++number, ++count) {
      GatheredLights reflected = reflected_lights(v, bsdf, number, lanes);
      light_up(probabilities, reflected);
      weigh(v, bsdf, counts, reflected, number, true, lanes, shadows[count]);
    }
  }
  // Vertex by vertex: rays that start at one point are traced well together.
  for (uint32_t rest = lanes; rest != 0; rest &= rest - 1) {
    const auto lane = static_cast<uint32_t>(std::countr_zero(rest));
    for (uint32_t number = 0; number < count; ++number)
      if (((shadows[number].lit >> lane) & 1U) != 0) add_shadow(v, lane, number, shadows[number]);
  }
}

template <typename Sink>
template <typename Bsdf>
GatheredLights VertexLanes<Sink>::reflected_lights(const GatheredVertices& v, const Bsdf& bsdf, uint32_t number,
                                                   uint32_t lanes) const {
  LaneNumbers choice, x, y;
  for (uint32_t lane = 0; lane < Lanes::kCount; ++lane) {
    const LightDraws& draws = v.members[lane]->sampled.reflections[number];
    choice[lane] = draws.spare, x[lane] = draws.light.x, y[lane] = draws.light.y;
  }
  const Vectors local = bsdf.sample_reflection(choice.load(), {x.load(), y.load()});
  const Vectors wi = v.frame.to_world(local);
  return {wi, lanes & packed(bsdf.has_microfacets() & (local.z > 0.0f) & (wi.dot(v.normal) > 0.0f))};
}

// Sets radiance and density, given the probabilities of light samples to choose the environment.
template <typename Sink>
void VertexLanes<Sink>::light_up(const LaneNumbers& probabilities, GatheredLights& reflected) const {
  const LightSetView& lights = stages_.world->lights;
  std::array<V3f, Lanes::kCount> directions;
  std::array<EnvironmentView::Location, Lanes::kCount> locations;
  std::array<EnvironmentView::Location*, Lanes::kCount> places;
  size_t count = 0;
  for (uint32_t rest = reflected.there; rest != 0; rest &= rest - 1) {
    const auto lane = static_cast<uint32_t>(std::countr_zero(rest));
    directions[count] = lane_of(reflected.wi, lane);
    places[count++] = &locations[lane];
  }
  lights.locate_in_environment(std::span(directions).first(count), std::span(places).first(count));
  LaneVectors radiances;
  LaneNumbers densities;
  for (uint32_t rest = reflected.there; rest != 0; rest &= rest - 1) {
    const auto lane = static_cast<uint32_t>(std::countr_zero(rest));
    const EnvironmentEval environment = lights.environment_eval(probabilities[lane], locations[lane]);
    radiances.set(lane, environment.radiance);
    densities[lane] = environment.pdf;
  }
  reflected.radiance = radiances.load();
  reflected.pdf = densities.load();
}

template <typename Sink>
template <typename Bsdf>
void VertexLanes<Sink>::weigh(const GatheredVertices& v, const Bsdf& bsdf, const PathStages::DirectCounts& counts,
                              const GatheredLights& lights, uint32_t number, bool reflected, uint32_t lanes,
                              ShadowLanes& shadows) const {
  const Vectors local = v.frame.to_local(lights.wi);
  BsdfEvalOf<Lanes> eval = bsdf.eval(local);
  const LaneMask no{};
  shadows.lit = lanes & lights.there & packed((lights.wi.dot(v.normal) > 0.0f) & (is_black(eval.value) == no));
  const Lanes bsdf_pdf = eval.pdf;
  eval.pdf = guides_.mixed(eval.pdf, local.z, lights.wi, shadows.lit);
  const auto [density, weight] =
      PathStages::weight_of(counts, lights.pdf, eval.pdf, eval.reflection_pdf, lights.is_environment,
                            reflected ? no == 0 : no, lights.is_delta);
  shadows.lit &= packed(density > 0.0f);
  if (shadows.lit == 0) return;
  const Vectors origin = origin_beside<Lanes>(v.position, v.position_error, v.normal, no);
  const WayToLight<Lanes> way = way_to_light(v.position, origin, lights.wi, lights.distance, lights.normal);
  shadows.rays = first_halves(origin, way.direction, way.length);
  // A second surface that is shared keeps its light before it is reflected.
  const Vectors reflectance = select(shared_second_, Vectors(Lanes(1.0f)), v.throughput * eval.value);
  shadows.contributions.store(reflectance * lights.radiance * Lanes(weight / density));
  if ((shadows.lit & casters_) != 0)
    share_light(v, lights, number, reflected, narrow_shares(bsdf, local, bsdf_pdf), shadows);
}

template <typename Sink>
void VertexLanes<Sink>::share_light(const GatheredVertices& v, const GatheredLights& lights, uint32_t number,
                                    bool reflected, const LaneNumbers& shares, ShadowLanes& shadows) const {
  for (uint32_t rest = shadows.lit & casters_; rest != 0; rest &= rest - 1) {
    const auto lane = static_cast<uint32_t>(std::countr_zero(rest));
    const ShadeGroup::Member& member = *v.members[lane];
    const PathState& state = *v.states[lane];
    if (!stages_.light_is_shared(member.surface, 1.0f, state)) continue;
    const LightSample environment{
        .wi = lane_of(lights.wi, lane), .distance = kInfinity, .kind = LightKind::environment};
    const LightSample& light = reflected ? environment : *context_.group.lights[member.first_light + number];
    const float weight = stages_.light_path_weight(member.surface, v.rays[lane]->time, light,
                                                   LightPathView::steps_of(shares[lane]), state);
    shadows.contributions.set(lane, shadows.contributions[lane] * weight);
  }
}

template <typename Sink>
void VertexLanes<Sink>::add_shadow(const GatheredVertices& v, uint32_t lane, uint32_t number,
                                   const ShadowLanes& shadows) {
  const PathState& state = *v.states[lane];
  const uint32_t slot = context_.active[v.numbers[lane]];
  const CameraSample& sample = context_.camera_samples[slot];
  const uint32_t key = ray_key(sample, state.dimension(kLightDimension));
  const accel::Ray ray = ray_of(shadows.rays[lane], number == 0 ? key : hash_combine(key, number), v.rays[lane]->time,
                                sample.address.index, kPassThinWalls);
  uint32_t light_class = state.light_class(state.bounce + 1U);
  if (shared_second_[lane] != 0) {
    reused_[lane]->light_wi = context_.group.lights[v.members[lane]->first_light]->wi;
    light_class = kReusedLight;
  }
  sink_.add_shadow(ray, {shadows.contributions[lane], slot, light_class});
}

} // namespace kindling
