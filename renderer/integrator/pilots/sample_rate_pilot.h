// A pilot that finds whether different numbers of samples pay, and by which rule they follow noise.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/integrator/pilots/block_noise.h"
#include "renderer/sampling/allocate_samples.h"

#include <cstdint>
#include <functional>

namespace kindling {

// The rule of a render's sample rates, and the cost of finding it.
struct RateChoice {
  RateRule rule;          // a scale of 0: the pilot finds too little to gain, or there was none
  double predicted = 1.0; // error in equal time, relative to the same samples for all pixels
  uint64_t paths = 0;     // of the pilot; 0: there was none
  RayCounters rays;       // of the pilot
  double pilot_s = 0.0;   // wall seconds
  double busy_s = 0.0;    // summed over the threads
};

// Renders blocks all over the image, with samples that are independent of the render's. planned:
// levels of the render, more than SampleRates::kPilotLevels. Numbers pay if the error is divided by
// more than min_gain.
//
// A function of world, camera and settings: threads do not change it. Runs on the threads of the
// current TBB arena. `stopped` is polled between blocks and may be empty.
[[nodiscard]] RateChoice choose_sample_rates(const World& world, const Camera& camera,
                                             const SamplePilotSettings& settings, uint32_t planned, double min_gain,
                                             const std::function<bool()>& stopped);

// Returns the cost of a sample of a block whose samples have taken so many rays each, in rays of
// bounces and shadows.
[[nodiscard]] double cost_of_sample(double rays);

} // namespace kindling
