// Traces the pilot of an image and finds the sample rates of its pixels.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/sampling/sample_rates.h"
#include "renderer/session/render_session.h"

#include <functional>
#include <optional>

namespace kindling {

struct Pilot {
  std::optional<SampleRates> rates; // of state.coverage.area(); empty: all pixels have the same samples, or stopped
  RayCounters rays;
  double busy_s = 0.0;       // of all threads
  double first_pass_s = 0.0; // see RenderStatistics; set by the caller
};

// Takes the first samples of each pixel, which are those of the image itself: where a whole block
// belongs to the state, which wants and lacks them, they are added to it; elsewhere they are
// dropped. The numbers of samples follow settings.rate_rule; they are a function of the image, its
// samples and the seed, not of the part of it that is rendered. `integrator` must be a path tracer.
// `stopped` is called between blocks; `on_done` gets the samples per pixel so far, from any
// thread: 1 once, when every pixel has its first.
[[nodiscard]] Pilot trace_pilot(const RenderSettings& settings, const Integrator& integrator, RenderState& state,
                                const std::function<bool()>& stopped, const std::function<void(double)>& on_done);

} // namespace kindling
