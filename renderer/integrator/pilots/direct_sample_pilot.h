// A pilot that chooses the number of light samples at a path's first surface.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/camera/camera.h"
#include "renderer/integrator/integrator.h"
#include "renderer/sampling/pixel_filter.h"
#include "renderer/world/world.h"

#include <cstdint>
#include <functional>

namespace kindling {

struct Guide;

struct DirectSamplePilotSettings {
  IntegratorSettings integrator; // of the path tracer, without light paths
  PixelFilter filter;
  const Guide* guide = nullptr; // of the render; null: none
  uint32_t seed = 0;            // of the render; the pilot's paths are independent of its samples
  uint64_t paths = 0;           // about so many; 0: no pilot
};

// The choice of a pilot, and its cost.
struct DirectSampleChoice {
  int samples = 1;        // IntegratorSettings::direct_samples
  double predicted = 1.0; // error times cost, relative to one sample
  uint64_t paths = 0;     // of the pilot; 0: there was none
  RayCounters rays;       // of the pilot
  double pilot_s = 0.0;   // wall seconds
  double busy_s = 0.0;    // summed over the threads
};

// Renders blocks all over the image twice with one light sample at the first surface and twice with
// kMaxChosenDirectSamples. Both have the same paths, so their difference in noise is that of the
// light samples, and their difference in rays is the cost. The noise with n samples is then a + b /
// n, at a cost of c + d n; the best n is chosen if it divides their product by
// kMinDirectSampleGain.
//
// A function of world, camera and settings: threads do not change it. Runs on the threads of the
// current TBB arena. `stopped` is polled between blocks and may be empty; once it returns true, the
// choice is 1.
[[nodiscard]] DirectSampleChoice choose_direct_samples(const World& world, const Camera& camera,
                                                       const DirectSamplePilotSettings& settings,
                                                       const std::function<bool()>& stopped);

inline constexpr int kMaxChosenDirectSamples = 4;
inline constexpr double kMinDirectSampleGain = 1.1;

} // namespace kindling
