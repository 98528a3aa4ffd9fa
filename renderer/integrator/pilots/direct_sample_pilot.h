// A pilot that chooses the light samples and reflection samples at a path's first surface.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/integrator/pilots/block_noise.h"

namespace kindling {

// The numbers that the pilot may choose; else settings.integrator has the number.
struct DirectSampleChoices {
  bool lights = true, reflections = true;
};

struct DirectSampleChoice : SampleChoice { // `count`: of light samples
  int reflections = 0;                     // IntegratorSettings::reflection_samples
};

// Renders blocks all over the image with one light sample at the first surface, with
// kMeasuredDirectSamples, and with two reflection samples as well (block_noise.h). The noise with
// n light samples and r reflection samples is then a + b / n + s / (1 + r), as the path itself
// takes one direction; the cost is c + d n + e r. The numbers with the smallest product are chosen
// if it is kMinDirectSampleGain times less than with one light sample and, where there are
// reflection samples, kMinReflectionSampleGain times less than without them. More light samples
// than were measured gain less than that says; they are chosen if the product is kMinUnmeasuredGain
// times less than with fewer. A probe ends the pilot
// early where neither can gain. Once `stopped` returns true, the choice is 1 and 0.
[[nodiscard]] DirectSampleChoice choose_direct_samples(const World& world, const Camera& camera,
                                                       const SamplePilotSettings& settings, DirectSampleChoices open,
                                                       const std::function<bool()>& stopped);

inline constexpr int kMeasuredDirectSamples = 8;
inline constexpr int kMaxChosenDirectSamples = 16;
inline constexpr double kMinDirectSampleGain = 1.1;
inline constexpr double kMinReflectionSampleGain = 1.03; // beyond that of light samples
inline constexpr double kMinUnmeasuredGain = 1.1;        // of more than kMeasuredDirectSamples over no more

} // namespace kindling
