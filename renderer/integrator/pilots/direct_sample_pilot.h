// A pilot that chooses the number of light samples at a path's first surface.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/integrator/pilots/block_noise.h"

namespace kindling {

// Renders blocks all over the image with one light sample at the first surface and with
// kMaxChosenDirectSamples (block_noise.h). The noise with n samples is then a + b / n, at a cost of
// c + d n; the best n is chosen if it divides their product by kMinDirectSampleGain. Once `stopped`
// returns true, the choice is 1.
[[nodiscard]] SampleChoice choose_direct_samples(const World& world, const Camera& camera,
                                                 const SamplePilotSettings& settings,
                                                 const std::function<bool()>& stopped);

inline constexpr int kMaxChosenDirectSamples = 4;
inline constexpr double kMinDirectSampleGain = 1.1;

} // namespace kindling
