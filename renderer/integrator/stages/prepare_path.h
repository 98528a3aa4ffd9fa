// First and last steps of a path at a surface: its footprint, its draws, its bounces and its sum.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/integrator/stages/path_stages.h"
#include "renderer/integrator/stages/sample_cone.h"

namespace kindling {

inline RayFootprint PathStages::measure_footprint(const accel::Ray& ray, float distance_m, PathState& state) const {
  const bool from_camera = state.cone.spread < 0.0f;
  if (from_camera) state.cone = state.specular_cone = sample_cone(*camera, ray.direction, sample_width);
  state.cone.width_m = state.cone.width_at(distance_m);
  state.specular_cone.width_m = state.specular_cone.width_at(distance_m);
  RayFootprint footprint{state.cone.width_m, state.bsdf_pdf == 0.0f};
  if (from_camera) footprint.width_m = first_footprint(*camera, ray, distance_m, state.cone.width_m, sample_width);
  return footprint;
}

// Returns the probability with which a path survives Russian roulette, given its throughput with
// the next direction; `guiding` is that of PathState. The square root spares paths that may still
// meet a bright light.
template <typename Real>
[[nodiscard]] Real survival_of(const Imath::Vec3<Real>& throughput, const Real& guiding) {
  return minimum(Real(1.0f), square_root(Real(max_component(throughput) * guiding)));
}

inline const LightProbabilities* PathStages::learned_probabilities(const SurfacePoint& surface) const {
  return light_probabilities ? &light_probabilities->find(surface.position, surface.geometric_normal) : nullptr;
}

inline LightQuery PathStages::light_query(const SurfacePoint& surface, float time, const SurfaceDraws& sampled,
                                          const PathInFlight& path) const {
  const bool reads_table = path.sample.sample_index < PresampledEnvironmentView::kMaxSamples;
  return {surface.position,
          surface.light_normal(),
          sampled.draws.light,
          sampled.draws.spare,
          sampled.light_probabilities,
          time,
          reads_table ? presampled : nullptr};
}

inline bool PathStages::count_bounce(Lobe lobe, float pdf, PathState& state) const {
  ++state.bounce;
  const bool narrow = lobe == Lobe::glossy && (pdf == 0.0f || pdf > kNarrowDensity);
  if (narrow && state.narrow_reflections < UINT8_MAX) ++state.narrow_reflections;
  bool within = true;
  switch (lobe) {
  case Lobe::diffuse: within &= state.diffuse_bounces() <= settings.max_diffuse_bounces; break;
  case Lobe::glossy: within &= ++state.glossy_bounces <= settings.max_glossy_bounces; break;
  case Lobe::transmission: within &= ++state.transmission_bounces <= settings.max_transmission_bounces; break;
  }
  within &= state.bounce - state.transmission_bounces <= settings.max_bounces;
  return within;
}

inline Rgb PathStages::radiance_of(PathState& state) const {
  const auto clamped = [](const Rgb& radiance, float largest) {
    const float peak = max_component(radiance);
    return peak > largest ? radiance * (largest / peak) : radiance;
  };
  if (settings.clamp_direct < kInfinity || settings.clamp_indirect < kInfinity) {
    state.light[kDirect] = clamped(state.light[kDirect], settings.clamp_direct);
    state.light[kIndirect] = clamped(state.light[kIndirect], settings.clamp_indirect);
  }
  return state.light[kEmission] + state.light[kDirect] + state.light[kIndirect];
}

} // namespace kindling
