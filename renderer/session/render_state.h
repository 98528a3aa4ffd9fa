// The state of a render: film, coverage, adaptive sampling, work. Saved, resumed from and merged.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/film/film.h"
#include "renderer/integrator/integrator.h"
#include "renderer/sampling/allocate_samples.h"
#include "renderer/session/adaptive_sampling.h"
#include "renderer/session/coverage.h"

#include <cstdint>
#include <optional>

namespace kindling {

// Work spent on a render over all runs and parts.
struct RenderWork {
  double render_s = 0.0; // wall seconds of all render phases
  double thread_s = 0.0; // wall seconds times threads
  RayCounters rays;      // without training
  uint32_t runs = 0;     // number of processes
  // Paths that the guide of the first run was trained with, if its time limit chose them: later
  // runs train the same guide.
  std::optional<uint64_t> training_paths;
  // The fraction of the samples with light paths, if a pilot chose it: later runs keep it.
  std::optional<float> light_paths;
  std::optional<float> photons; // IntegratorSettings::photons, likewise
  // IntegratorSettings::direct_samples, reflection_samples and path_reuse, likewise.
  std::optional<int> direct_samples, reflection_samples, path_reuse;
  // The rule of sample rates, if a pilot looked for one, likewise; a scale of 0: there are none.
  std::optional<RateRule> rate_rule;
};

struct RenderState {
  Film film; // its crop is coverage.area(): the crop or a part of it; with adaptive sampling whole blocks
  Coverage coverage;
  AdaptiveState adaptive; // empty without adaptive sampling
  RenderWork work;
};

} // namespace kindling
