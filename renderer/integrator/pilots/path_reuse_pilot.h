// A pilot that chooses the number of pixels that share their paths.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/integrator/pilots/block_noise.h"

namespace kindling {

// Renders blocks all over the image without path reuse and with groups of the largest size
// (block_noise.h). The noise with groups of n is then a + b / n; the best n is chosen if it divides
// noise times cost by kMinPathReuseGain. Once `stopped` returns true, the choice is 1.
[[nodiscard]] SampleChoice choose_path_reuse(const World& world, const Camera& camera,
                                             const SamplePilotSettings& settings, const std::function<bool()>& stopped);

inline constexpr double kMinPathReuseGain = 1.1;

} // namespace kindling
