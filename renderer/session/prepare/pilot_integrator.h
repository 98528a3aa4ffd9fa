// Settings of the paths that prepare a render.
// SPDX-License-Identifier: Apache-2.0
#pragma once

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

} // namespace kindling
