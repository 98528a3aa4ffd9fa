// Table of the render strategies that must have the same mean.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/session/render_session.h"

#include <array>

namespace kindling::test {

struct Strategy {
  const char* name;
  void (*apply)(RenderSettings& settings); // to the base settings
  accel::Kind accelerator = accel::Kind::embree;
  bool same_numbers = false; // uses the random numbers of the base, which reduces the noise of the difference
  uint32_t seeds = 48;       // number of images
  bool guided = false;       // by a guide trained on the scene
  bool for_casters = false;  // traces light paths, for scenes with casters alone
  bool for_still = false;    // for scenes without motion alone

  [[nodiscard]] constexpr bool suits(bool casters, bool moving) const {
    return (casters || !for_casters) && !(moving && for_still);
  }
};

// Returns the settings of the reference strategy: Sobol points, which have little noise, no
// roulette, Embree, one thread.
[[nodiscard]] inline RenderSettings base_settings(const V2i& size_px, int max_bounces, uint32_t samples) {
  RenderSettings settings;
  settings.size_px = size_px;
  settings.samples_per_pixel = samples;
  settings.sampler = SamplerKind::sobol;
  settings.filter = PixelFilter({FilterKind::box});
  settings.threads = 1;
  settings.integrator.max_bounces = max_bounces;
  settings.integrator.roulette_start_bounce = 1000;
  return settings;
}

inline constexpr std::array kStrategies{
    Strategy{"independent", [](RenderSettings& s) { s.sampler = SamplerKind::independent; }, accel::Kind::embree, false,
             54}, // plain random numbers
    Strategy{"blue-noise", [](RenderSettings& s) { s.sampler = SamplerKind::blue_noise; }},
    Strategy{"roulette from bounce 0", [](RenderSettings& s) { s.integrator.roulette_start_bounce = 0; },
             accel::Kind::embree, true, 32},
    Strategy{"kd-tree", [](RenderSettings&) {}, accel::Kind::kdtree, true, 16},
    Strategy{"guiding", [](RenderSettings&) {}, accel::Kind::embree, false, 48, true},
    Strategy{"direct samples", [](RenderSettings& s) { s.integrator.direct_samples = 16; }, accel::Kind::kdtree, false,
             48, true},
    Strategy{"direct, jittered",
             [](RenderSettings& s) {
               s.sampler = SamplerKind::jittered;
               s.integrator.direct_samples = 2;
               s.integrator.reflection_samples = 2;
             },
             accel::Kind::embree, false, 72},
    Strategy{"reflection samples", [](RenderSettings& s) { s.integrator.reflection_samples = 4; }, accel::Kind::kdtree,
             false, 64},
    Strategy{"light paths", [](RenderSettings& s) { s.integrator.light_paths = 1.0f; }, accel::Kind::kdtree, false, 48,
             false, true},
    Strategy{"light paths and guiding", [](RenderSettings& s) { s.integrator.light_paths = 0.5f; }, accel::Kind::embree,
             false, 48, true},
    Strategy{"light paths, chosen", [](RenderSettings& s) { s.chooses_light_paths = true; }, accel::Kind::kdtree, false,
             48, false, true},
    Strategy{"path reuse", [](RenderSettings& s) { s.integrator.path_reuse = 8; }, accel::Kind::kdtree, false, 64,
             false, false, true},
    Strategy{"path reuse and guiding",
             [](RenderSettings& s) {
               s.sampler = SamplerKind::blue_noise;
               s.integrator.path_reuse = 4;
               s.integrator.direct_samples = 2;
               s.integrator.reflection_samples = 1;
               s.integrator.roulette_start_bounce = 0;
             },
             accel::Kind::embree, false, 48, true, false, true},
    Strategy{"sample rates",
             [](RenderSettings& s) {
               s.sample_rates = SampleRateKind::noise;
               s.min_rates_gain = 1.0;
             },
             accel::Kind::kdtree, false, 72},
    Strategy{"all together",
             [](RenderSettings& s) {
               s.sampler = SamplerKind::blue_noise;
               s.integrator.roulette_start_bounce = 1;
               s.integrator.direct_samples = 3;
               s.integrator.reflection_samples = 2;
               s.sample_rates = SampleRateKind::noise;
               s.min_rates_gain = 1.0;
             },
             accel::Kind::kdtree, false, 64, true},
};

// The number of strategies for a scene with or without casters, moving or not.
[[nodiscard]] constexpr size_t strategy_count(bool casters, bool moving) {
  size_t count = 0;
  for (const Strategy& strategy : kStrategies) count += strategy.suits(casters, moving) ? 1 : 0;
  return count;
}

} // namespace kindling::test
