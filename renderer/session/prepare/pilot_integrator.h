// Settings of the paths that prepare a render.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/integrator/pilots/block_noise.h"
#include "renderer/session/render_session.h"

#include <bit>

namespace kindling {

// Returns the settings of the integrators of pilots and of training. Their samplers plan a single
// sample, so the environment filter is divided by the samples of the render: its areas, and with
// them the noise, are the same.
[[nodiscard]] inline IntegratorSettings pilot_integrator(const RenderSettings& settings) {
  IntegratorSettings integrator = settings.integrator;
  integrator.environment_filter /= static_cast<float>(std::bit_ceil(settings.planned()));
  return integrator;
}

// Returns the settings of a pilot of about so many paths. `guide` may be null.
[[nodiscard]] inline SamplePilotSettings sample_pilot(const RenderSettings& settings, const Guide* guide,
                                                      uint64_t paths) {
  SamplePilotSettings pilot{.integrator = pilot_integrator(settings),
                            .filter = settings.filter,
                            .guide = guide,
                            .seed = settings.seed,
                            .paths = paths};
  pilot.integrator.presamples_environment = false; // too few paths to pay for a table
  return pilot;
}

} // namespace kindling
