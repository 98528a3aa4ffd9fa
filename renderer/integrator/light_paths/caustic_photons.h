// Light paths over glass and metal to other surfaces: the training data of a caustic guide.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/guiding/caustic_guide.h"
#include "renderer/integrator/integrator.h"

#include <cstdint>
#include <functional>
#include <vector>

namespace kindling {

struct CausticPhotonSettings {
  IntegratorSettings integrator; // of the path tracer that is to be guided
  PixelFilter filter;
  uint32_t seed = 0; // of the render
  uint64_t first_path = 0, paths = 0;
};

// Traces light paths over casters (stages/light_path_view.h) and returns where their light arrives
// without a diffuse bounce on its way. There are no records where no light with a size reaches a
// caster. Runs on the threads of the current TBB arena, on which the result does not depend.
// `stopped` is polled and may be empty; once it returns true, the result is incomplete.
[[nodiscard]] std::vector<CausticRecord> trace_caustic_photons(const World& world, const Camera& camera,
                                                               const CausticPhotonSettings& settings,
                                                               const std::function<bool()>& stopped,
                                                               RayCounters& counters);

} // namespace kindling
