// Next-event estimation of a path: light samples and reflection samples of a surface.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/integrator/stages/path_stages.h"
#include "renderer/integrator/stages/reuse_paths.h"
#include "renderer/sampling/mis.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <optional>
#include <span>

namespace kindling {

// Returns whether the surface may scatter light from a direction. Opaque surfaces scatter none from
// below their horizon. Where shading and geometric normal disagree on whether a direction is
// reflected or transmitted, it carries no light.
inline bool PathStages::may_receive(const Vertex& vertex, const V3f& wi) {
  const bool front = wi.dot(vertex.surface.geometric_normal) > 0.0f;
  return vertex.layers ? front == (wi.dot(vertex.frame.normal) > 0.0f) : front;
}

// Returns whether the light of a sample is left to the direction of the path.
inline bool PathStages::is_left(const Vertex& vertex, const LightSample& light) {
  return vertex.environment_left && light.kind == LightKind::environment;
}

inline std::optional<V3f> PathStages::reflection_direction(const Vertex& vertex, uint32_t number, uint32_t count,
                                                           const PathInFlight& path) {
  LightDraws draws;
  if (vertex.sampled.reflections) {
    draws = vertex.sampled.reflections[number];
  } else {
    const BounceAddress address = reflection_address(path, number, count);
    const BounceDraws both = draw_bounce(address.address, address.dimension);
    draws = {both.light, both.spare};
  }
  const V3f wi = vertex.bsdf.bsdf().sample_reflection(draws.spare, draws.light);
  return wi.z > 0.0f ? std::optional(vertex.frame.to_world(wi)) : std::nullopt;
}

inline LightSample PathStages::reflected_light(float probability, const V3f& wi,
                                               const EnvironmentView::Location& at) const {
  const EnvironmentEval environment = world->lights.environment_eval(probability, at);
  return {.wi = wi,
          .distance = kInfinity,
          .radiance = environment.radiance,
          .pdf = environment.pdf,
          .kind = LightKind::environment};
}

template <typename Lights, typename Sink>
[[gnu::always_inline]] inline void PathStages::add_lights(const Vertex& vertex, const Lights& lights,
                                                          const PathInFlight& path, Sink& sink,
                                                          ReusedPath* reused) const {
  const auto count = static_cast<uint32_t>(lights.size());
  if (count == 0) return;
  const DirectCounts counts{count, reflection_sample_count(vertex, path.state)};
  if constexpr (requires { lights.data(); }) { // all are there, and not sampled one after the other
    if (counts.all() >= kMinEvalsTogether) {
      add_lights_together(vertex, lights, counts, path, sink, reused);
      return;
    }
  }
  const float environment_probability = counts.reflections > 0 ? probability_of_environment(vertex) : 0.0f;
  for (uint32_t number = 0; number < counts.all(); ++number) {
    std::optional<LightSample> light;
    if (number < count) {
      light = lights[number];
    } else if (const std::optional<V3f> wi = reflection_direction(vertex, number - count, counts.reflections, path)) {
      light = reflected_light(environment_probability, *wi, world->lights.locate_in_environment(*wi));
    }
    if (light && !is_left(vertex, *light) && may_receive(vertex, light->wi))
      light_vertex(vertex, *light, vertex.bsdf.eval(light->wi), number, counts, path, sink, reused);
  }
}

// Returns density and weight of a sample, or of eight. Where there are reflection samples, light of
// the environment is found by three techniques: the power heuristic weights light samples against
// directions of the BSDF, and the balance heuristic those of reflection samples against the one of
// the path.
template <typename Real, typename Condition>
inline PathStages::SampleWeight<Real> PathStages::weight_of(const DirectCounts& counts, const Real& light_pdf,
                                                            const Real& bsdf_pdf, const Real& reflection_pdf,
                                                            const Condition& environment, const Condition& reflected,
                                                            const Condition& delta) {
  // Densities of all samples together.
  const Real pdf = light_pdf * static_cast<float>(counts.lights);
  Real directions_pdf = bsdf_pdf;
  if (counts.reflections > 0) {
    const Real beside = bsdf_pdf + static_cast<float>(counts.reflections) * reflection_pdf;
    directions_pdf = select(environment, beside, bsdf_pdf);
  }
  const Real density = select(reflected, directions_pdf, pdf);
  const Real weight = power_heuristic(density, select(reflected, pdf, directions_pdf));
  return {density, select(delta, Real(1.0f), weight)};
}

#if !KINDLING_ON_GPU
// Light samples in lanes, as far as weigh() reads them, and the contributions that it finds. Lanes
// that are left over are undefined.
struct PathStages::LightLanes {
  LaneVectors radiance;
  LaneNumbers pdf;         // of one light sample
  LaneNumbers environment; // 1: light of the environment; else 0
  LaneNumbers reflected;   // 1: a reflection sample; else 0
  LaneNumbers delta;       // 1: LightSample::delta; else 0
  LaneVectors contribution;

  void set(size_t lane, const Rgb& light, float density, LightKind kind, bool of_reflection, bool is_delta) {
    radiance.set(lane, light);
    pdf[lane] = density;
    environment[lane] = kind == LightKind::environment ? 1.0f : 0.0f;
    reflected[lane] = of_reflection ? 1.0f : 0.0f;
    delta[lane] = is_delta ? 1.0f : 0.0f;
  }
};

// Up to eight contributions with the bits of light_vertex().
inline uint32_t PathStages::weigh(const Vertex& vertex, const PathState& state, const DirectCounts& counts,
                                  const BsdfEvals& evals, LightLanes& lights) {
  const Imath::Vec3<Lanes> value(Lanes::load(evals.red.data()), Lanes::load(evals.green.data()),
                                 Lanes::load(evals.blue.data()));
  const Lanes none(0.0f);
  const auto [density, weight] =
      weight_of(counts, lights.pdf.load(), Lanes::load(evals.pdfs.data()), Lanes::load(evals.reflection_pdfs.data()),
                lights.environment.load() > none, lights.reflected.load() > none, lights.delta.load() > none);
  const Lanes scale = vertex.surface.alpha * weight / density;
  const Imath::Vec3<Lanes> radiance = lights.radiance.load();
  const auto channel = [&](int c) { return Lanes(state.throughput[c] * value[c] * radiance[c] * scale); };
  lights.contribution.store({channel(0), channel(1), channel(2)});
  const LaneMask black = (value.x == none) & (value.y == none) & (value.z == none);
  return packed((density > none) & ~black);
}
#endif

// Several samples of a surface that may bring light, before the BSDF is evaluated.
struct PathStages::ReadySamples {
  static constexpr size_t kMax = kMaxDirectSamples + kMaxReflectionSamples;

  std::array<EvalDirections, (kMax + kEvalsTogether - 1) / kEvalsTogether> directions; // of light samples first
  std::array<uint32_t, kMax> numbers;
  std::array<EnvironmentView::Location, kMaxReflectionSamples> locations; // by the number of the reflection sample
  uint32_t count = 0;
  float environment_probability = 0.0f;

  void add(uint32_t number, const V3f& direction) {
    directions[count / kEvalsTogether].add(direction);
    numbers[count++] = number;
  }
};

template <typename Lights>
inline void PathStages::find_ready(const Vertex& vertex, const Lights& lights, const DirectCounts& counts,
                                   const PathInFlight& path, ReadySamples& samples) const {
  for (uint32_t number = 0; number < counts.lights; ++number) {
    const std::optional<LightSample>& light = lights[number];
    if (light && !is_left(vertex, *light) && may_receive(vertex, light->wi)) samples.add(number, light->wi);
  }
  std::array<V3f, kMaxReflectionSamples> reflections;
  std::array<EnvironmentView::Location*, kMaxReflectionSamples> located;
  uint32_t reflected = 0;
  for (uint32_t number = 0; number < counts.reflections; ++number) {
    const std::optional<V3f> wi = reflection_direction(vertex, number, counts.reflections, path);
    if (!wi || !may_receive(vertex, *wi)) continue;
    samples.add(counts.lights + number, *wi);
    reflections[reflected] = *wi;
    located[reflected++] = &samples.locations[number];
  }
  if (reflected == 0) return;
  samples.environment_probability = probability_of_environment(vertex);
  world->lights.locate_in_environment(std::span(reflections).first(reflected), std::span(located).first(reflected));
}

// Adds several samples. The BSDF is evaluated towards as many of them together as possible, and
// where nothing but their weights is needed, these are computed together, too.
template <typename Lights, typename Sink>
inline void PathStages::add_lights_together(const Vertex& vertex, const Lights& lights, const DirectCounts& counts,
                                            const PathInFlight& path, Sink& sink, ReusedPath* reused) const {
  ReadySamples samples;
  find_ready(vertex, lights, counts, path, samples);
  [[maybe_unused]] const bool weights_alone = only_weights(vertex, path, sink);
  for (uint32_t first = 0; first < samples.count; first += kEvalsTogether) {
    const EvalDirections& directions = samples.directions[first / kEvalsTogether];
    BsdfEvals evals;
    vertex.bsdf.eval(directions, evals);
#if !KINDLING_ON_GPU
    if (weights_alone) {
      add_weighted(vertex, lights, counts, samples, first, evals, path, sink);
      continue;
    }
#endif
    for (size_t i = 0; i < directions.size(); ++i) {
      const uint32_t number = samples.numbers[first + i];
      if (number < counts.lights)
        light_vertex(vertex, *lights[number], evals[i], number, counts, path, sink, reused);
      else
        light_vertex(
            vertex,
            reflected_light(samples.environment_probability, directions[i], samples.locations[number - counts.lights]),
            evals[i], number, counts, path, sink, reused);
    }
  }
}

#if !KINDLING_ON_GPU
// Adds up to eight samples, from `first` on, by their weights.
template <typename Lights, typename Sink>
inline void PathStages::add_weighted(const Vertex& vertex, const Lights& lights, const DirectCounts& counts,
                                     const ReadySamples& samples, uint32_t first, const BsdfEvals& evals,
                                     const PathInFlight& path, Sink& sink) const {
  const EvalDirections& directions = samples.directions[first / kEvalsTogether];
  LightLanes lanes;
  for (size_t i = 0; i < directions.size(); ++i) {
    const uint32_t number = samples.numbers[first + i];
    if (number < counts.lights) {
      const LightSample& light = *lights[number];
      lanes.set(i, light.radiance, light.pdf, light.kind, false, light.delta);
    } else {
      const EnvironmentEval light =
          world->lights.environment_eval(samples.environment_probability, samples.locations[number - counts.lights]);
      lanes.set(i, light.radiance, light.pdf, LightKind::environment, true, false);
    }
  }
  const uint32_t used = (1U << directions.size()) - 1U;
  for (uint32_t rest = weigh(vertex, path.state, counts, evals, lanes) & used; rest != 0; rest &= rest - 1) {
    const auto i = static_cast<uint32_t>(std::countr_zero(rest));
    const uint32_t number = samples.numbers[first + i];
    const LightSample environment{.wi = directions[i], .distance = kInfinity};
    const LightSample& light = number < counts.lights ? *lights[number] : environment;
    sink.add_shadow(shadow_ray(vertex, light, number, path),
                    {lanes.contribution[i], path.slot, path.state.light_class(path.state.bounce + 1U)});
  }
}
#endif

// Returns whether nothing but its weight changes the light of a sample between the light and the
// path, and no sink records the sample itself.
template <typename Sink>
inline bool PathStages::only_weights(const Vertex& vertex, const PathInFlight& path, const Sink& sink) const {
  if (Sink::kSplits || sink.records() || path.state.in_medium) return false;
  if (joins_light_paths<Sink>() && path.state.light_path_scale != 0.0f) return false;
  return !(vertex.layers && vertex.surface.layers.boundary);
}

// Returns the shadow ray of a sample.
inline accel::Ray PathStages::shadow_ray(const Vertex& vertex, const LightSample& light, uint32_t number,
                                         const PathInFlight& path) {
  const uint32_t key = ray_key(path.sample, path.state.dimension(kLightDimension));
  accel::Ray ray = make_shadow_ray(vertex.surface, light, number == 0 ? key : hash_combine(key, number),
                                   path.sample.address.index, vertex.time);
  ray.flags = kPassThinWalls;
  return ray;
}

// Next-event estimation, given the BSDF towards the light. A contribution is added to the path once
// its shadow ray is traced.
template <typename Sink>
inline void PathStages::light_vertex(const Vertex& vertex, const LightSample& light, const BsdfEval& eval,
                                     uint32_t number, const DirectCounts& counts, const PathInFlight& path, Sink& sink,
                                     ReusedPath* reused) const {
  const SurfacePoint& surface = vertex.surface;
  const PathState& state = path.state;
  const float side = light.wi.dot(surface.geometric_normal);
  if (is_black(eval.value)) return;
  const auto [density, weight] = weight_of(counts, light.pdf, eval.pdf, eval.reflection_pdf,
                                           light.kind == LightKind::environment, number >= counts.lights, light.delta);
  if (!(density > 0.0f)) return;
  Rgb contribution = state.throughput * eval.value * light.radiance * (surface.alpha * weight / density);
  if (state.in_medium || (side < 0.0f && vertex.layers && surface.layers.boundary))
    contribution *= transmittance_to_light(surface, vertex.layers, side, light.distance, path);
  if (joins_light_paths<Sink>()) contribution *= light_path_weight(vertex, light, side, state);
  const accel::Ray ray = shadow_ray(vertex, light, number, path);
  sink.offer_light(vertex, light, contribution);
  if (Sink::kReuses && reused && state.bounce == 1) {
    reused->light_wi = light.wi;
    sink.add_shadow(ray, {light.radiance * (weight / density), path.slot, kReusedLight});
    return;
  }
  sink.add_shadow(ray, {contribution, path.slot, state.light_class(state.bounce + 1U)});
}

} // namespace kindling
